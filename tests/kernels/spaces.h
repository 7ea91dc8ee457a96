/// Every Hamiltonian of this build as a list of types, with its default parameters and rays to try it on.
#pragma once

#include "tests/kernels/places.h"

// First, because the templates below call these functions on a type without a namespace to find them by.
#include "kernels/numeric/quad.h"

#include "all_hamiltonians.inc"
#include "kernels/abi.h"
#include "kernels/equations/system.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

extern "C" const kagero::Module* kagero_kernels();

namespace kagero::test {

namespace detail {
template <class First, class... Rest>
struct AllButFirst {
    using Types = ::testing::Types<Rest...>;
};
}  // namespace detail

// clang-format off
using AllHamiltonians = detail::AllButFirst<void
#define KAGERO_HAMILTONIAN(TYPE) , hamiltonians::TYPE
#include "hamiltonians.inc"
#undef KAGERO_HAMILTONIAN
    >::Types;
// clang-format on

/// Typed tests are named after their Hamiltonian.
struct HamiltonianName {
    template <class H>
    static std::string GetName(int) { return H::name; }
};

/// The parameters a scene gets that sets none; room for one more, because a Hamiltonian may have none.
template <class H>
std::array<double, H::parameters.size() + 1> default_parameters() {
    std::array<double, H::parameters.size() + 1> values{};
    for (std::size_t i = 0; i < H::parameters.size(); ++i) values[i] = H::parameters[i].fallback;
    return values;
}

/// The number of H in the module.
template <class H>
std::uint32_t index_of() {
    std::uint32_t h = 0;
    while (std::string(kagero_kernels()->hamiltonians[h].name) != H::name) ++h;
    return h;
}

/// H alone, and Ω·(H − H0) where H declares an Ω.
template <class H>
std::vector<bool> rescalings() {
    if constexpr (Rescalable<H>) return {false, true};
    else return {false};
}

/// Uniform numbers, the same on every machine.
class Random {
public:
    explicit Random(std::uint64_t seed) : engine_(seed) {}
    double operator()(double least, double greatest) {
        return least + (greatest - least) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
    }
    int below(int n) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(n)); }

private:
    std::mt19937_64 engine_;
};

/// The ray from q along d.
template <class H>
Failure start_ray(const double (&q)[3], const double (&d)[3], RayStart& ray) {
    return kagero_kernels()->start(index_of<H>(), default_parameters<H>().data(), q, d, &ray);
}

/// Rays with H = H0 in random directions from random places of the domain, none captured from the start.
template <class H>
std::vector<RayStart> random_rays(std::size_t n, std::uint64_t seed) {
    Random random(seed);
    const auto k = default_parameters<H>();
    const double reach = place_in(H::name).reach;
    const auto anywhere = [&] { return random(-reach, reach); };
    std::vector<RayStart> rays;
    for (int attempt = 0; rays.size() < n && attempt < 10000; ++attempt) {
        const double q[3] = {anywhere(), anywhere(), anywhere()}, d[3] = {random(-1, 1), random(-1, 1), random(-1, 1)};
        RayStart ray;
        if (start_ray<H>(q, d, ray) != Failure::none) continue;
        const Vec3<double> at{q[0], q[1], q[2]}, along{d[0], d[1], d[2]};
        if constexpr (Bounded<H>)
            if (!(H::domain(make_parameters<H>(k.data()), at) > 0)) continue;
        if constexpr (Capturing<H>)
            if (!(H::captured(make_parameters<H>(k.data()), at, {ray.p[0], ray.p[1], ray.p[2]}, along, ray.pt) > 0))
                continue;
        rays.push_back(ray);
    }
    EXPECT_EQ(rays.size(), n) << "too few places from which " << H::name << " starts a ray";
    return rays;
}

/// Rays that bend much, and are neither captured nor out of the medium on the path. Exact in float, so that every
/// number type starts on the same ray; H = H0 to the rounding of float only, unless `on_level`.
template <class H>
RayStart bent_ray(int which = 0, bool on_level = false) {
    constexpr double d[][3] = {{-0.3, 0.8, 0.5}, {0.1, -0.4, 0.9}, {-0.2, -0.7, -0.6}};
    RayStart ray;
    EXPECT_EQ(start_ray<H>(place_in(H::name).q, d[which], ray), Failure::none) << H::name;
    if (on_level) return ray;
    for (double& p : ray.p) p = static_cast<float>(p);
    return ray;
}
/// The same path in the integration parameter for all methods.
template <class H>
inline constexpr double path_length = place_in(H::name).path;
inline constexpr int bent_rays = 3;

template <class V>
State<V> state_of(const RayStart& ray) {
    using S = ScalarOf<V>;
    State<V> s;
    for (int k = 0; k < 3; ++k) s.y[k] = V(S(ray.q[k])), s.y[3 + k] = V(S(ray.p[k]));
    s.y[6] = V(S(ray.pt));
    return s;
}

}  // namespace kagero::test
