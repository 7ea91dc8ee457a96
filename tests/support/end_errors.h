/// Compares the error layers of a picture with true errors. The true ray ends are known in closed form for two scenes:
/// orbits around a Schwarzschild black hole, and circles in a fisheye.
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

/// All rays from the camera are arcs of circles through the opposite point (1, 0, 0). A screen at x = 0.5 stops them
/// before that point.
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

inline Double3 to_double3(const double (&x)[3]) {
    return {x[0], x[1], x[2]};
}

/// A function that returns the exact end of the ray with a given RayStart. Its second argument is the computed end. The
/// returned status is `failed` if the closed form does not apply to the ray.
using ExactEnd = std::function<RayEnd(const RayStart&, const RayEnd&)>;

/// Returns the end with the exact direction of a ray that escapes from a Schwarzschild black hole, at r = 20 r_g.
/// The closed form applies to rays with b > b_c (1 + 1e-4).
inline RayEnd exact_escape(const RayStart& ray, const RayEnd& end) {
    RayEnd exact = end;
    const Double3 q = to_double3(ray.q), p = to_double3(ray.p);
    const double b = length(cross(q, p)) / ray.pt;
    exact.status = Status::failed;
    if (end.status != Status::escaped || !(b > critical_impact * (1 + 1e-4))) return exact;
    exact.status = Status::escaped;
    const Orbit orbit(b);
    const double r0 = length(q), angle = orbit.swept_around(r0) + orbit.phase(1 / r0) - orbit.phase(1 / 20.0);
    const Velocity v = orbit.velocity_after(r0, angle);
    const Double3 outward = unit(q), across = unit(subtract(p, scaled(outward, dot(p, outward))));
    const double speed = std::hypot(v.radial, v.transverse), c = std::cos(angle), s = std::sin(angle);
    for (std::size_t k = 0; k < 3; ++k) {
        const double outward_at_end = c * outward[k] + s * across[k], across_at_end = c * across[k] - s * outward[k];
        exact.v[k] = (v.radial * outward_at_end + v.transverse * across_at_end) / speed;
    }
    return exact;
}

/// Returns the end with the exact position of a ray in the fisheye, at x = 0.5. Let u be the coordinate along the part
/// of the ray's direction d at the camera that is normal to the x axis. The circle through (±1, 0) in the (x, u) plane
/// with tangent d at (−1, 0) has its centre at u = −d_x/d_u.
inline RayEnd exact_hit(const RayStart& ray, const RayEnd& end) {
    RayEnd exact = end;
    const long double y = ray.p[1], z = ray.p[2], across = std::hypot(y, z), c = ray.p[0] / across;
    const long double u = 0.75L / (c + std::sqrt(c * c + 0.75L));
    exact.q[0] = 0.5;
    exact.q[1] = double(u * y / across);
    exact.q[2] = double(u * z / across);
    return exact;
}

/// The estimate of the error of one pixel in a layer, and the true error; both in units of a pixel.
struct ErrorPair {
    double estimate, truth;
};

/// The estimated and true errors of the pixels of a picture.
struct Comparison {
    std::vector<ErrorPair> pairs;
    std::size_t without_estimate = 0;  ///< Number of pixels with NaN in the layer.

    /// Returns the fraction of `pairs` in which the ratio of estimate and true error is between 1/factor and factor.
    double share_within(double factor) const {
        std::size_t within = 0;
        for (const ErrorPair& pair : pairs)
            within += pair.estimate <= factor * pair.truth && pair.truth <= factor * pair.estimate;
        return double(within) / double(pairs.size());
    }
};

/// Renders a scene with one method and precision. Returns the estimates in `layer` and the true errors of the pixels.
/// Pixels whose true error is below `min_roundings` rounding errors of the end are left out: their errors are random,
/// and the rounding errors of the closed form are as large. `step` is the tolerance if the method is adaptive.
inline Comparison compare(const char* scene, const std::string& method, double step, const ExactEnd& exact,
                          const std::string& layer, const std::string& precision, double min_roundings,
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
        for (std::uint32_t x = 0; x < 48; ++x) starts.push_back(pixel_ray_start(*plan, x, y));
    std::vector<RayEnd> ends;
    trace(*plan, starts, ends);
    Comparison compared;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        const RayEnd expected = exact(starts[i], ends[i]);
        const double estimate = film.plane(layer)[i];
        if (expected.status == Status::failed) continue;
        if (std::isnan(estimate)) {
            ++compared.without_estimate;
            continue;
        }
        const double truth = distance_in_pixels(*plan, expected, ends[i]);
        if (truth >= min_roundings * (precision == "float" ? 0x1p-24 : 0x1p-53) / pixel_size(plan->description(), 1))
            compared.pairs.push_back({estimate, truth});
    }
    return compared;
}

}  // namespace kagero::test
