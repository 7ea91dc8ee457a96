/// The list of all Hamiltonians of this build as types, with their default parameters and with test rays.
#pragma once

#include "tests/kernels/start_regions.h"

// quad.h must precede the headers below. Argument-dependent lookup does not find the functions of __float128, which
// belongs to no namespace, so that these functions must be declared before the templates that call them.
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
/// Removes the first type of a list. Lists that are made with KAGERO_HAMILTONIAN begin with `void`, because each
/// expansion of this macro begins with a comma.
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

/// Names the instances of typed tests after their Hamiltonian.
struct HamiltonianName {
    template <class H>
    static std::string GetName(int) { return H::name; }
};

/// Returns the default values of the parameters of H. The array has one more element, because it must not be empty.
template <class H>
std::array<double, H::parameters.size() + 1> default_parameters() {
    std::array<double, H::parameters.size() + 1> values{};
    for (std::size_t i = 0; i < H::parameters.size(); ++i) values[i] = H::parameters[i].default_value;
    return values;
}

/// Returns the index of H in the module.
template <class H>
std::uint32_t index_of() {
    std::uint32_t h = 0;
    while (std::string(kagero_kernels()->hamiltonians[h].name) != H::name) ++h;
    return h;
}

/// Returns the possible values of `rescaled`: false for H, and true for Ω·(H − H0) if H declares a time rescaling Ω.
template <class H>
std::vector<bool> rescalings() {
    if constexpr (Rescalable<H>) return {false, true};
    else return {false};
}

/// Uniformly distributed random numbers, the same on every machine.
class Random {
public:
    explicit Random(std::uint64_t seed) : engine_(seed) {}
    /// Returns a random number between two bounds.
    double operator()(double least, double greatest) {
        return least + (greatest - least) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
    }
    /// Returns a random integer from 0 to n − 1.
    int below(int n) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(n)); }

private:
    std::mt19937_64 engine_;
};

/// Sets `ray` to the start of the ray from q in direction d, and returns the failure, if any.
template <class H>
Failure start_ray(const double (&q)[3], const double (&d)[3], RayStart& ray) {
    return kagero_kernels()->start(index_of<H>(), default_parameters<H>().data(), q, d, &ray);
}

/// Returns n rays with H = H0, in random directions from random positions inside the domain. None is captured at its
/// start.
template <class H>
std::vector<RayStart> random_rays(std::size_t n, std::uint64_t seed) {
    Random random(seed);
    const auto k = default_parameters<H>();
    const double half_width = start_region_of(H::name).half_width;
    const auto coordinate = [&] { return random(-half_width, half_width); };
    std::vector<RayStart> rays;
    for (int attempt = 0; rays.size() < n && attempt < 10000; ++attempt) {
        const double q[3] = {coordinate(), coordinate(), coordinate()};
        const double d[3] = {random(-1, 1), random(-1, 1), random(-1, 1)};
        RayStart ray;
        if (start_ray<H>(q, d, ray) != Failure::none) continue;
        const Vec3<double> position{q[0], q[1], q[2]}, direction{d[0], d[1], d[2]};
        const Vec3<double> momentum{ray.p[0], ray.p[1], ray.p[2]};
        if constexpr (Bounded<H>)
            if (!(H::domain(make_parameters<H>(k.data()), position) > 0)) continue;
        if constexpr (Capturing<H>)
            if (!(H::captured(make_parameters<H>(k.data()), position, momentum, direction, ray.pt) > 0)) continue;
        rays.push_back(ray);
    }
    EXPECT_EQ(rays.size(), n) << "Too few random positions are legal starts of rays of " << H::name << ".";
    return rays;
}

/// Returns the start of one of three strongly bent rays. On a path of length `path_length` the ray is neither captured
/// nor leaves the medium. Position and momentum are exactly representable in float, so that all number types start with
/// the same ray. H is therefore equal to H0 only to the rounding of float. With `on_level`, H is equal to H0 to the
/// rounding of double, because the momentum is not rounded to float.
template <class H>
RayStart bent_ray(int ray_index = 0, bool on_level = false) {
    constexpr double d[][3] = {{-0.3, 0.8, 0.5}, {0.1, -0.4, 0.9}, {-0.2, -0.7, -0.6}};
    RayStart ray;
    EXPECT_EQ(start_ray<H>(start_region_of(H::name).q, d[ray_index], ray), Failure::none) << H::name;
    if (on_level) return ray;
    for (double& p : ray.p) p = static_cast<float>(p);
    return ray;
}
/// Length of the path over which tests integrate the bent rays of H, in the integration parameter τ.
template <class H>
inline constexpr double path_length = start_region_of(H::name).path_length;
/// Number of bent rays per space.
inline constexpr int bent_ray_count = 3;

/// Returns the state at the start of a ray, the same in all lanes.
template <class V>
State<V> state_of(const RayStart& ray) {
    using S = ScalarOf<V>;
    State<V> s;
    for (int k = 0; k < 3; ++k) {
        s.y[k] = V(S(ray.q[k]));
        s.y[3 + k] = V(S(ray.p[k]));
    }
    s.y[6] = V(S(ray.pt));
    return s;
}

}  // namespace kagero::test
