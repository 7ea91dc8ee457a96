/// How a ray has continued at surfaces.
#pragma once

#include "appearance/patch.h"

#include <cstdint>

namespace kagero {

/// The continuation of one ray at the surfaces that it has met. A path consists of segments; each surface that sends
/// the light on ends one segment and begins the next.
struct PathState {
    Double3 weight{1, 1, 1};        ///< Factor of the light at the end of the path.
    Double3 light{0, 0, 0};         ///< Light of the diffuse surfaces on the path that emit light, with its factors.
    double frequency = 1;           ///< Factor by which the momentum was scaled, so that |p_t| = 1 at the surfaces.
    std::uint64_t surfaces = 0;     ///< Identifies the surfaces and branches of the path: equal for equal sequences.
    std::uint32_t bounces = 0;      ///< Number of surfaces that have sent the light on.
    std::uint32_t medium = 0;       ///< Medium of the last segment (index of Plan::medium).
    std::uint32_t scatterings = 0;  ///< Number of diffuse surfaces that have sent the path into random directions.
};

}  // namespace kagero
