/// The search for surfaces in bundles of neighbouring rays.
#pragma once

#include "geometry/clearance/clearance.h"

#include <array>

namespace kagero {

/// Points of neighbouring rays: of the ray in the middle of a cell of the picture, which is the first point, and of
/// eight around it.
using BundleSlice = std::array<Double3, 9>;

/// A part of a bundle of neighbouring rays.
struct BundlePart {
    std::array<BundleSlice, 3> slices;  ///< At the beginning, in the middle and at the end.
    double radius;         ///< All points between those of a slice are in a ball of this radius around its first point.
    double across, along;  ///< Greatest distances of these points from the first one, across and along the middle ray.
    double bend;           ///< Greatest distance of a ray from the line segments between its points in adjacent slices.
};

/// Returns true if no surface intersects a part of a bundle. Returns false if this is uncertain. The triangles of the
/// face `ignored` are left out. The part does not meet a triangle outside one of two tubes around the middle ray: that
/// with the part's radius, or the thinner and longer one with the radius `across`. Nor does it meet a triangle if all
/// points of the slices lie on one side of its plane. Their distance must then exceed the bend plus a quarter of the
/// differences within a slice.
bool is_clear(const Geometry& geometry, const BundlePart& part, const std::optional<Face>& ignored);

}  // namespace kagero
