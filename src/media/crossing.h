/// Crossings of a straight ray with boundaries of media.
#pragma once

#include "scene/vector3.h"

#include <cstdint>
#include <limits>

namespace kagero {

/// A straight ray from `origin` along the unit vector `direction`.
struct StraightRay {
    Double3 origin, direction;
};

/// The first crossing of a ray with one surface.
struct Crossing {
    double distance = std::numeric_limits<double>::infinity();  ///< Distance from the origin; ∞ without a crossing.
    bool against_normal = false;  ///< True if the ray moves against the normal of the surface there.
    /// Distance of the first point at which the ray passes within rounding of an edge, or is nearly tangent. It is
    /// uncertain whether the ray crosses the surface there. ∞ if there is no such point.
    double uncertain_distance = std::numeric_limits<double>::infinity();
};

/// Index of a triangle that does not exist.
inline constexpr std::uint32_t no_triangle = 0xffffffff;

/// Adds the crossing with a sphere whose normal points outward. If the ray starts on the sphere (`starts_on_it`), the
/// start is not a crossing.
void add_sphere(const StraightRay& ray, const Double3& center, double radius, bool starts_on_it, Crossing& crossing);

/// Adds the crossing with the triangle abc, whose normal is (b − a) × (c − a).
void add_triangle(const StraightRay& ray, const Double3& a, const Double3& b, const Double3& c, Crossing& crossing);

}  // namespace kagero
