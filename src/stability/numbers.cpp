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
        if (const ParameterInfo& one = info.parameters[i]; const int power = power_of_length(one.unit))
            parameters += std::string(one.name) + " = " + number(one.default_value * std::pow(scale, power)) + "\n";
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
    const double small = run.in_float() ? 1e-40 : 1e-310;
    const auto rays = [](double tiny) {
        std::vector<RayInput> all;
        for (int i = 0; i < 64; ++i) all.push_back({{0.3 + 0.01 * i, tiny, tiny}, {0.2, 1, tiny}});
        return all;
    };
    for (const char* method : {"srkn6", "gauss8", "rk4"}) {
        const auto plan = run.plan(
            space_text("fisheye", "", std::string("method = \"") + method + "\"\nescape_radius = 10\nmax_steps = 500"));
        const auto seconds = [&](double tiny) {
            std::vector<RayEnd> ends;
            return trace(plan, start_rays(plan, rays(tiny)), ends).seconds;
        };
        const auto unscaled = run.ends(plan, rays(0)), tiny = run.ends(plan, rays(small));
        for (std::size_t i = 0; i < unscaled.size(); ++i) {
            run.expect_status(tiny[i], unscaled[i].status, method);
            run.measure("difference", distance(tiny[i].q, {unscaled[i].q[0], unscaled[i].q[1], unscaled[i].q[2]}),
                        run.in_float() ? 1e-5 : 1e-13);
        }
        // The minimum times in seconds are compared, because other processes may use the processor.
        double with_small = HUGE_VAL, with_zeros = HUGE_VAL;
        for (int i = 0; i < 50 && !(i > 2 && with_small < 20 * with_zeros); ++i) {
            with_small = std::min(with_small, seconds(small));
            with_zeros = std::min(with_zeros, seconds(0));
        }
        run.expect(with_small < 20 * with_zeros, "runs with denormals take " + three_digits(with_small / with_zeros) +
                                                     " times as long as with zeros; at most 20 times is expected, " +
                                                     method);
    }
}

namespace {

/// Returns a scene with a hole and a camera of 48 × 32 pixels.
std::string float_scene(const char* method, double step) {
    return hole_scene_text(method, step) +
           "[camera]\nposition = [0, -40, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\nfov = 30\n[film]\nsize = [48, 32]\n";
}

std::vector<RayEnd> picture_ends(CaseRun& run, const Options& options, const char* method, double step) {
    SceneDescription scene = run.scene(float_scene(method, step), true);
    scene.integrator.escape_radius = 50;
    const auto plan = make_plan(std::move(scene), options);
    std::vector<RayStart> starts;
    for (std::uint32_t y = 0; y < 32; ++y)
        for (std::uint32_t x = 0; x < 48; ++x) starts.push_back(pixel_ray_start(plan, x, y));
    return run.ends(plan, starts);
}

/// Returns the sorted distances of the ray ends from the reference. Only rays with b > 1.2 b_c are included, whose
/// deflection multiplies errors by at most about ten.
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
                               " rays have another status in float than in double; at most 2 may, " + method +
                               ", step " + number(step));
    std::sort(errors.begin(), errors.end());
    return errors;
}

}  // namespace

// Compares every ray of a picture in float with the same ray in double with small steps. Gauss methods use compensated
// summation, so that shorter steps must not increase the median error. The 90th and 99th percentiles depend on few
// rays and may increase by a factor of 4. Without compensation, 32 times as many steps would increase them by a factor
// of 32. The errors of the other methods are reported without a bound.
void float_floor(CaseRun& run) {
    if (!run.in_float()) return;
    Options in_double = run.options();
    in_double.precision = Precision::float64;
    const auto reference = picture_ends(run, in_double, "gauss8", 0.05);
    for (const char* method : {"gauss8", "gauss12", "suzuki4-nine", "rk4"}) {
        const bool compensated = std::string(method).starts_with("gauss");
        double least[] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, greatest_error = 0;
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
                    run.expect(error < (k == 0 ? 1 : 4) * least[k] + 4 * 0x1p-18,
                               "error " + std::to_string(error) + " (quantile " + number(quantiles[k]) + ") at step " +
                                   number(step) + " is too large compared with " + std::to_string(least[k]) +
                                   " at a longer step, " + method);
                least[k] = std::min(least[k], error);
                if (k != 1) percentiles += (k == 0 ? (percentiles.empty() ? "" : ", ") : " and ") + three_digits(error);
            }
            greatest_error = errors.back();
        }
        if (compensated) run.measure("greatest error at the shortest step", greatest_error, 1e-3);
        if (!run.in_scalar())
            run.note(std::string(method) +
                     ", median and 99th percentile of the error at steps 0.4 to 0.0125: " + percentiles);
    }
}

}  // namespace kagero::stability
