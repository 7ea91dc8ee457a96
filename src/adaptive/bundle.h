/// Tests whether a bundle of neighbouring rays passes close to a surface that none of the traced rays meets.
#pragma once

#include "adaptive/ray_nodes.h"
#include "geometry/geometry.h"

#include <array>
#include <optional>

namespace kagero {

/// The paths of the ray in the middle of a cell, and of the rays at its edges and corners.
struct Bundle {
    std::span<const PathVertex> middle;
    std::array<std::span<const PathVertex>, 8> outer;
};

/// Returns true if no ray between the outer rays of a bundle can meet a surface other than `end_face`, on which all of
/// its traced rays end; empty: they end on no surface.
///
/// Points of the paths that lie at the same fraction of their lengths are compared. Around the middle ray, the bundle
/// is contained in balls whose radius is the distance to the outer rays, with a margin. Where the bundle bends or
/// folds, the mean of opposite rays differs from the middle ray, and the margin is greater. The bundle is divided along
/// its length until every part is clear of all surfaces (is_clear), or not much longer than wide.
bool keeps_clear(const Bundle& bundle, const Geometry& geometry, const std::optional<Face>& end_face);

}  // namespace kagero
