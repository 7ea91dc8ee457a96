/// Pictures of the sky from a map of the rays from one point.
#pragma once

#include "view/sky/direction_map.h"
#include "view/sky/orbit_family.h"

#include <variant>

namespace kagero {

/// A picture in 8-bit sRGB, and what is known about its rays.
struct MapPicture {
    std::vector<unsigned char> rgb;
    std::uint64_t traced = 0;  ///< Rays that were traced for this picture, for the map and for single pixels.
    double max_error = 0;      ///< Greatest estimated error of an interpolated direction, in pixels.
    double p99_error = 0;      ///< The error that 99 % of the interpolated pixels do not exceed.
    double trace_seconds = 0, shade_seconds = 0;
};

/// Greatest error of an interpolated direction, in pixels. Rays with a greater one are traced.
inline constexpr double max_map_error = 0.1;

/// The rays from one point of a space: a family of orbits if the space is spherical.
using SkyMap = std::variant<DirectionMap, OrbitFamily>;
/// Returns a map without rays for the camera of a plan.
SkyMap new_sky_map(const Plan& plan);

/// Computes the picture of a plan for whose scene shows_only_sky (scene/sky_only.h) holds. The map must contain only
/// rays from the same position in the same space; it is refined. The sky is filtered with one lookup per pixel, which
/// takes less time than the filter of `render`, and is less sharp where the sky is compressed along one direction.
MapPicture picture_from_map(const Plan& plan, SkyMap& map);

}  // namespace kagero
