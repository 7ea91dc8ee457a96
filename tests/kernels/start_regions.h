/// Start positions of test rays, one row per space. The positions fit the length scale of the space and are away from
/// its edges and discontinuities. The last row applies to all other spaces, which bend rays within a few units of
/// length around the origin. N is the index of refraction, and n is the factor of |p|²/2 in H.
#pragma once

#include <string_view>

namespace kagero::test {

/// The start positions of one space, in its unit of length.
struct StartRegion {
    std::string_view hamiltonian;
    double q[3];         ///< Start of the strongly bent test rays; exactly representable in float.
    double path_length;  ///< Length of these rays in the integration parameter τ; H is smooth on the whole path.
    double half_width;   ///< Random start positions have |x|, |y|, |z| below this value.
};

inline constexpr StartRegion start_regions[] = {
    {"duct", {0.375, 0.25, 1.0}, 0.8, 1.25},        // |z|³ is not smooth at z = 0
    {"fiber", {0.75, -0.5, 0.25}, 4.8, 1.75},       // no ray exists beyond x² + y² = 11
    {"fisheye", {0.5, 0.25, 0.375}, 0.6, 1.5},      // the fisheye has the radius 1
    {"gradient", {0.5, 0.25, 0.375}, 3.2, 4},       // no ray exists above z = 10
    {"kerr", {5.125, 0.375, 0.75}, 4, 8},           // M = 1: photon orbits have radii up to 4
    {"layer", {0.25, 0.125, 0.03125}, 0.16, 0.25},  // the layer has the thickness 0.1
    {"luneburg", {0.375, 0.25, -0.125}, 0.4, 0.5},  // N is not smooth at the radius 1
    {"mirage", {0.375, 0.25, 0.125}, 0.8, 0.5},     // n → 0 near z = 1.4
    {"", {3.125, 0.375, 0.75}, 4, 6},
};

/// Returns the row of a space, or the last row if it has none.
constexpr const StartRegion& start_region_of(std::string_view hamiltonian) {
    const StartRegion* region = start_regions;
    while (!region->hamiltonian.empty() && region->hamiltonian != hamiltonian) ++region;
    return *region;
}

}  // namespace kagero::test
