#include "stability/numbers.h"

#include "plan/units.h"
#include "stability/orbits.h"

#include <algorithm>
#include <cmath>

namespace kagero::stability {

namespace {

/// Returns a scene with a floor and a space with default parameters, in which all lengths are multiplied by `scale`.
std::string scaled_text(const HamiltonianInfo& info, double scale) {
    std::string parameters;
    for (std::uint32_t i = 0; i < info.parameter_count; ++i)
        if (const ParameterInfo& p = info.parameters[i]; const int power = power_of_length(p.unit))
            parameters += std::string(p.name) + " = " + number(p.default_value * std::pow(scale, power)) + "\n";
    return space_text(info.name, parameters, "escape_radius = " + number(30 * scale)) +
           rectangle("floor", {-9 * scale, -9 * scale, -0.7 * scale}, {18 * scale, 0, 0}, {0, 18 * scale, 0}) +
           "[camera]\nposition = [0, " + number(-3 * scale) +
           ", 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [8, 8]\n";
}

}  // namespace

void scaled_scene(CaseRun& run) {
    const auto ends_at_scale = [&](const HamiltonianInfo& info, double scale) {
        std::vector<RayInput> rays;
        for (int i = 0; i < 24; ++i)
            rays.push_back({{0.3 * scale, -3 * scale, 0.4 * scale}, {0.2 * i - 2.4, 1, 0.03 * (i % 8) - 0.21}});
        return run.ends(run.plan(scaled_text(info, scale), true), rays);
    };
    const Catalogue spaces = catalogue(run.options().isa);
    for (std::uint32_t h = 0; h < spaces.hamiltonian_count; ++h) {
        const HamiltonianInfo& info = spaces.hamiltonians[h];
        if (info.parameter_count == 0) continue;  // empty space and formulas have no parameters to scale
        const auto unscaled = ends_at_scale(info, 1);
        for (const double scale : {1e-30, 1e-7, 1e-3, 1e3, 1e7, 1e10}) {
            const auto ends = ends_at_scale(info, scale);
            for (std::size_t i = 0; i < ends.size(); ++i) {
                run.expect_status(ends[i], unscaled[i].status,
                                  std::string(info.name) + ", scale " + number(scale) + ", ray " + std::to_string(i));
                if (ends[i].status != unscaled[i].status ||
                    (ends[i].status != Status::hit && ends[i].status != Status::escaped))
                    continue;
                run.measure(std::string("change of direction, ") + info.name,
                            distance(ends[i].v, {unscaled[i].v[0], unscaled[i].v[1], unscaled[i].v[2]}),
                            run.in_float() ? 5e-3 : 1e-6);  // step control is not scale-invariant
            }
        }
    }
}

void denormals(CaseRun& run) {
    const double denormal = run.in_float() ? 1e-40 : 1e-310;
    // Returns rays with y = z = `value` at the start and the z component `value` of the direction.
    const auto rays_with = [](double value) {
        std::vector<RayInput> rays;
        for (int i = 0; i < 64; ++i) rays.push_back({{0.3 + 0.01 * i, value, value}, {0.2, 1, value}});
        return rays;
    };
    for (const char* method : {"srkn6", "gauss8", "rk4"}) {
        const auto plan = run.plan(
            space_text("fisheye", "", std::string("method = \"") + method + "\"\nescape_radius = 10\nmax_steps = 500"));
        const auto seconds_with = [&](double value) {
            std::vector<RayEnd> ends;
            return trace(plan, start_rays(plan, rays_with(value)), ends).seconds;
        };
        const auto zero_ends = run.ends(plan, rays_with(0)), denormal_ends = run.ends(plan, rays_with(denormal));
        for (std::size_t i = 0; i < zero_ends.size(); ++i) {
            const double* q = zero_ends[i].q;
            run.expect_status(denormal_ends[i], zero_ends[i].status, method);
            run.measure("distance of the ray ends from those with zeros",
                        distance(denormal_ends[i].q, {q[0], q[1], q[2]}), run.in_float() ? 1e-5 : 1e-13);
        }
        // The shortest times are compared, because other processes may use the processor during a run.
        double denormal_seconds = HUGE_VAL, zero_seconds = HUGE_VAL;
        for (int i = 0; i < 50 && !(i > 2 && denormal_seconds < 20 * zero_seconds); ++i) {
            denormal_seconds = std::min(denormal_seconds, seconds_with(denormal));
            zero_seconds = std::min(zero_seconds, seconds_with(0));
        }
        run.expect(denormal_seconds < 20 * zero_seconds,
                   "runs with denormals take " + three_digits(denormal_seconds / zero_seconds) +
                       " times as long as with zeros; at most 20 times is expected, " + method);
    }
}

namespace {

/// Returns a scene with a hole and a camera of 48 × 32 pixels.
std::string float_scene(const char* method, double step) {
    return hole_scene_text(method, step) +
           "[camera]\nposition = [0, -40, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\nfov = 30\n[film]\nsize = [48, 32]\n";
}

/// Traces the rays of all pixels of `float_scene` and returns their ends.
std::vector<RayEnd> picture_ends(CaseRun& run, const Options& options, const char* method, double step) {
    SceneDescription scene = run.scene(float_scene(method, step), true);
    scene.integrator.escape_radius = 50;
    const auto plan = make_plan(std::move(scene), options);
    std::vector<RayStart> starts;
    for (std::uint32_t y = 0; y < 32; ++y)
        for (std::uint32_t x = 0; x < 48; ++x) starts.push_back(pixel_ray_start(plan, x, y));
    return run.ends(plan, starts);
}

/// Returns the sorted distances of the ray ends in float from the reference. Only rays with b > 1.2 b_c are included,
/// whose deflection multiplies errors by at most about ten. At most two of all rays may have another status than in the
/// reference.
std::vector<double> float_errors(CaseRun& run, const std::vector<RayEnd>& reference, const char* method, double step) {
    const auto float_ends = picture_ends(run, run.options(), method, step);
    std::vector<double> errors;
    std::size_t flips = 0;
    for (std::size_t i = 0; i < float_ends.size(); ++i) {
        flips += float_ends[i].status != reference[i].status;
        const double *q = reference[i].q, *v = reference[i].v;
        const double b = std::hypot(q[1] * v[2] - q[2] * v[1], q[2] * v[0] - q[0] * v[2], q[0] * v[1] - q[1] * v[0]);
        if (float_ends[i].status != Status::escaped || reference[i].status != Status::escaped ||
            b < 1.2 * critical_impact)
            continue;
        errors.push_back(distance(float_ends[i].q, {q[0], q[1], q[2]}));
    }
    run.expect(flips <= 2, std::to_string(flips) +
                               " rays have another status in float than in double; at most 2 are permitted, " + method +
                               ", step " + number(step));
    std::sort(errors.begin(), errors.end());
    return errors;
}

}  // namespace

// Compares every ray of a picture in float with the same ray in double with a short step. Gauss methods use compensated
// summation, so shorter steps must not increase the median error. The 90th and 99th percentiles depend on few
// rays and may increase by a factor of 4. Without compensation, 32 times as many steps would increase them by a factor
// of 32. The errors of the other methods are reported without a bound.
void float_floor(CaseRun& run) {
    if (!run.in_float()) return;
    Options in_double = run.options();
    in_double.precision = Precision::float64;
    const auto reference = picture_ends(run, in_double, "gauss8", 0.05);
    for (const char* method : {"gauss8", "gauss12", "suzuki4-nine", "rk4"}) {
        const bool compensated = std::string(method).starts_with("gauss");
        double least_errors[] = {HUGE_VAL, HUGE_VAL, HUGE_VAL};  // over all longer steps, one per quantile
        double greatest_error = 0;
        std::string percentiles;
        for (const double step : {0.4, 0.2, 0.1, 0.05, 0.025, 0.0125}) {
            const auto errors = float_errors(run, reference, method, step);
            run.expect(!errors.empty(),
                       std::string("no ray escapes both in float and in double, ") + method + ", step " + number(step));
            if (errors.empty()) continue;
            constexpr double quantiles[] = {0.5, 0.9, 0.99};
            for (int k = 0; k < 3; ++k) {
                const double error = errors[static_cast<std::size_t>(quantiles[k] * double(errors.size() - 1))];
                // Fluctuations by rounding of up to four ulp of r = 50 are permitted.
                if (compensated)
                    run.expect(error < (k == 0 ? 1 : 4) * least_errors[k] + 4 * 0x1p-18,
                               "error " + std::to_string(error) + " (quantile " + number(quantiles[k]) + ") at step " +
                                   number(step) + " is too large compared with " + std::to_string(least_errors[k]) +
                                   " at a longer step, " + method);
                least_errors[k] = std::min(least_errors[k], error);
                if (k != 1) percentiles += (k == 0 ? (percentiles.empty() ? "" : ", ") : " and ") + three_digits(error);
            }
            greatest_error = errors.back();
        }
        if (compensated) run.measure("greatest error at the shortest step", greatest_error, 1e-3);
        if (!run.is_scalar())
            run.note(std::string(method) +
                     ", median and 99th percentile of the error at steps 0.4 to 0.0125: " + percentiles);
    }
}

}  // namespace kagero::stability
