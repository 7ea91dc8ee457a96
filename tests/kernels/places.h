/// Where tests of a space start rays: its own scale, away from its edges and kinks. A space without a row is one some
/// scene lengths wide.
#pragma once

#include <string_view>

namespace kagero::test {

struct Place {
    std::string_view hamiltonian;
    double q[3];   ///< exact in float; from here rays are bent much
    double path;   ///< in the integration parameter: so far they stay where H is smooth
    double reach;  ///< random places have |x|, |y|, |z| below this
};

inline constexpr Place places[] = {
    {"duct", {0.375, 0.25, 1.0}, 0.8, 1.25},          // |z|³ is not smooth at z = 0
    {"fiber", {0.75, -0.5, 0.25}, 4.8, 1.75},         // no ray beyond x² + y² = 11
    {"fisheye", {0.5, 0.25, 0.375}, 0.6, 1.5},        // R = 1
    {"gradient", {0.5, 0.25, 0.375}, 3.2, 4},         // no ray above z = 10
    {"kerr", {5.125, 0.375, 0.75}, 4, 8},             // M = 1: photon orbits up to r = 4
    {"layer", {0.25, 0.125, 0.03125}, 0.16, 0.25},    // thickness 0.1
    {"luneburg", {0.375, 0.25, -0.125}, 0.4, 0.5},     // R = 1, where N is not smooth
    {"mirage", {0.375, 0.25, 0.125}, 0.8, 0.5},        // n → 0 near z = 1.4
    {"", {3.125, 0.375, 0.75}, 4, 6},
};

constexpr const Place& place_in(std::string_view hamiltonian) {
    const Place* p = places;
    while (!p->hamiltonian.empty() && p->hamiltonian != hamiltonian) ++p;
    return *p;
}

}  // namespace kagero::test
