/// Layers that say how wrong a picture's rays are, beside closed forms: the orbits around a Schwarzschild hole, the
/// circles of a fisheye.
#pragma once

#include "tests/support/plan_fixture.h"
#include "tests/support/schwarzschild_orbit.h"

#include "rays/camera.h"
#include "accuracy/ray_errors.h"
#include "scene/vector3.h"

#include <cmath>
#include <functional>

namespace kagero::test {

inline constexpr const char* hole_scene = R"([space]
hamiltonian = "schwarzschild"
rg = 1
[integrator]
escape_radius = 20
[camera]
position = [0, -10, 0]
look_at = [0, 0, 0]
up = [0, 0, 1]
[film]
size = [48, 48]
layers = ["position_error", "rounding_error"]
)";

// From the eye all rays go in circles through the opposite point (1, 0, 0); before it stands a screen.
inline constexpr const char* fisheye_scene = R"([space]
hamiltonian = "fisheye"
n0 = 2
radius = 1
[integrator]
escape_radius = 10
[camera]
position = [-1, 0, 0]
look_at = [0, 0, 0]
up = [0, 0, 1]
[film]
size = [48, 48]
layers = ["position_error", "rounding_error"]
[[object]]
name = "screen"
shape = "rectangle"
origin = [0.5, -5, -5]
edge_u = [0, 10, 0]
edge_v = [0, 0, 10]
)";

inline Double3 of(const double (&x)[3]) {
    return {x[0], x[1], x[2]};
}

/// Where the ray of a RayStart should end; a status of `failed` where the closed form says nothing.
using Exact = std::function<RayEnd(const RayStart&, const RayEnd&)>;

inline RayEnd exact_escape(const RayStart& ray, const RayEnd& end) {
    RayEnd exact = end;
    const Double3 q = of(ray.q), p = of(ray.p);
    const double b = length(cross(q, p)) / ray.pt;
    exact.status = Status::failed;
    if (end.status != Status::escaped || !(b > critical_impact * (1 + 1e-4))) return exact;
    exact.status = Status::escaped;
    const Orbit orbit(b);
    const double r0 = length(q), angle = orbit.swept_around(r0) + orbit.phase(1 / r0) - orbit.phase(1 / 20.0);
    const Velocity v = orbit.velocity_after(r0, angle);
    const Double3 outward = unit(q), across = unit(subtract(p, scaled(outward, dot(p, outward))));
    const double size = std::hypot(v.along, v.aside), c = std::cos(angle), s = std::sin(angle);
    for (std::size_t k = 0; k < 3; ++k)
        exact.v[k] = (v.along * (c * outward[k] + s * across[k]) + v.aside * (c * across[k] - s * outward[k])) / size;
    return exact;
}

/// The circle through (−1, 0, 0) along d has its centre at c = −d_x/d_u from the middle, d_u the part of d across x.
inline RayEnd exact_hit(const RayStart& ray, const RayEnd& end) {
    RayEnd exact = end;
    const long double y = ray.p[1], z = ray.p[2], across = std::hypot(y, z), c = ray.p[0] / across;
    const long double u = 0.75L / (c + std::sqrt(c * c + 0.75L));
    exact.q[0] = 0.5, exact.q[1] = double(u * y / across), exact.q[2] = double(u * z / across);
    return exact;
}

/// What a layer says beside what is true, of the pixels where both mean something.
struct Pair {
    double estimate, truth;
};

struct Compared {
    std::vector<Pair> pairs;
    std::size_t unknown = 0;

    /// Share of the pixels whose estimate is the truth within a factor.
    double share_within(double factor) const {
        std::size_t within = 0;
        for (const Pair& pair : pairs)
            within += pair.estimate <= factor * pair.truth && pair.truth <= factor * pair.estimate;
        return double(within) / double(pairs.size());
    }
};

/// Pixels of which the truth is less than `clear` roundings of the end itself are left out: there luck rules, and the
/// closed form has roundings of its own.
inline Compared compare(const char* scene, const std::string& method, double step, const Exact& exact,
                        const std::string& layer, const std::string& precision, double clear,
                        Overrides overrides = {}) {
    Options options;
    options.precision = precision_named(precision);
    const char* key = method == "dp54" || method == "dp85" || method == "rkf78" ? "tolerance" : "step";
    overrides.push_back("integrator.method=\"" + method + "\"");
    overrides.push_back(std::string("integrator.") + key + "=" + std::to_string(step));
    const auto plan = plan_of_text(scene, overrides, options);
    Film film(48, 48, {"position_error", "rounding_error"});
    render_with_errors(*plan, film);
    std::vector<RayStart> starts;
    for (std::uint32_t y = 0; y < 48; ++y)
        for (std::uint32_t x = 0; x < 48; ++x) starts.push_back(pixel_ray(*plan, x, y));
    std::vector<RayEnd> ends;
    trace(*plan, starts, ends);
    Compared compared;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        const RayEnd should = exact(starts[i], ends[i]);
        const double estimate = film.plane(layer)[i];
        if (should.status == Status::failed) continue;
        if (std::isnan(estimate)) {
            ++compared.unknown;
            continue;
        }
        const double truth = pixels_apart(*plan, should, ends[i]);
        if (truth >= clear * (precision == "float" ? 0x1p-24 : 0x1p-53) / pixel_size(plan->description(), 1))
            compared.pairs.push_back({estimate, truth});
    }
    return compared;
}

}  // namespace kagero::test
