#include "stability/numbers.h"

#include "plan/units.h"
#include "stability/orbits.h"

#include <algorithm>
#include <cmath>

namespace kagero::stability {

namespace {

/// A space with all its defaults before a floor, `scale` times as large.
std::string scaled_text(const HamiltonianInfo& info, double scale) {
    std::string parameters;
    for (std::uint32_t i = 0; i < info.parameter_count; ++i)
        if (const ParameterInfo& one = info.parameters[i]; const int power = power_of_length(one.unit))
            parameters += std::string(one.name) + " = " + number(one.fallback * std::pow(scale, power)) + "\n";
    return space_text(info.name, parameters, "escape_radius = " + number(30 * scale)) +
           rectangle("floor", {-9 * scale, -9 * scale, -0.7 * scale}, {18 * scale, 0, 0}, {0, 18 * scale, 0}) +
           "[camera]\nposition = [0, " + number(-3 * scale) +
           ", 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [8, 8]\n";
}

}  // namespace

void scaled_scene(Trial& trial) {
    const auto at = [&](const HamiltonianInfo& info, double scale) {
        std::vector<RayInput> rays;
        for (int i = 0; i < 24; ++i)
            rays.push_back({{0.3 * scale, -3 * scale, 0.4 * scale}, {0.2 * i - 2.4, 1, 0.03 * (i % 8) - 0.21}});
        return trial.ends(trial.plan(scaled_text(info, scale), true), rays);
    };
    const Catalogue spaces = catalogue(trial.options().isa);
    for (std::uint32_t h = 0; h < spaces.hamiltonian_count; ++h) {
        const HamiltonianInfo& info = spaces.hamiltonians[h];
        if (info.parameter_count == 0) continue;  // empty space, and formulas, which know of no lengths
        const auto plain = at(info, 1);
        for (const double scale : {1e-30, 1e-7, 1e-3, 1e3, 1e7, 1e10}) {
            const auto ends = at(info, scale);
            for (std::size_t i = 0; i < ends.size(); ++i) {
                trial.expect_status(ends[i], plain[i].status,
                                    std::string(info.name) + ", scale " + number(scale) + ", ray " + std::to_string(i));
                if (ends[i].status != plain[i].status ||
                    (ends[i].status != Status::hit && ends[i].status != Status::escaped))
                    continue;
                trial.measure(std::string("change of direction, ") + info.name,
                              distance(ends[i].v, {plain[i].v[0], plain[i].v[1], plain[i].v[2]}),
                              trial.in_float() ? 5e-3 : 1e-6);  // steps under control know of lengths near 1
            }
        }
    }
}

void denormals(Trial& trial) {
    const double small = trial.in_float() ? 1e-40 : 1e-310;
    const auto rays = [](double tiny) {
        std::vector<RayInput> all;
        for (int i = 0; i < 64; ++i) all.push_back({{0.3 + 0.01 * i, tiny, tiny}, {0.2, 1, tiny}});
        return all;
    };
    for (const char* method : {"srkn6", "gauss8", "rk4"}) {
        const auto plan = trial.plan(
            space_text("fisheye", "", std::string("method = \"") + method + "\"\nescape_radius = 10\nmax_steps = 500"));
        const auto seconds = [&](double tiny) {
            std::vector<RayEnd> ends;
            return trace(plan, start_rays(plan, rays(tiny)), ends).seconds;
        };
        const auto plain = trial.ends(plan, rays(0)), tiny = trial.ends(plan, rays(small));
        for (std::size_t i = 0; i < plain.size(); ++i) {
            trial.expect_status(tiny[i], plain[i].status, method);
            trial.measure("difference", distance(tiny[i].q, {plain[i].q[0], plain[i].q[1], plain[i].q[2]}),
                          trial.in_float() ? 1e-5 : 1e-13);
        }
        // Best against best: others use the processor as well.
        double with_small = HUGE_VAL, with_zeros = HUGE_VAL;
        for (int i = 0; i < 50 && !(i > 2 && with_small < 20 * with_zeros); ++i)
            with_small = std::min(with_small, seconds(small)), with_zeros = std::min(with_zeros, seconds(0));
        trial.expect(with_small < 20 * with_zeros, std::string("20 times slower with ") + method);
    }
}

namespace {

/// A camera before the hole, 48 × 32 rays out to r = 50.
std::string float_scene(const char* method, double step) {
    return hole(method, step) +
           "[camera]\nposition = [0, -40, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\nfov = 30\n[film]\nsize = [48, 32]\n";
}

std::vector<RayEnd> picture_ends(Trial& trial, const Options& options, const char* method, double step) {
    SceneDescription scene = trial.scene(float_scene(method, step), true);
    scene.integrator.escape_radius = 50;
    const auto plan = make_plan(std::move(scene), options);
    std::vector<RayStart> starts;
    for (std::uint32_t y = 0; y < 32; ++y)
        for (std::uint32_t x = 0; x < 48; ++x) starts.push_back(pixel_ray(plan, x, y));
    return trial.ends(plan, starts);
}

/// Errors of a picture's rays, sorted; of those whose deflection multiplies no error more than about tenfold: b > 1.2
/// b_c.
std::vector<double> float_errors(Trial& trial, const std::vector<RayEnd>& reference, const char* method, double step) {
    const auto rough = picture_ends(trial, trial.options(), method, step);
    std::vector<double> errors;
    std::size_t flips = 0;
    for (std::size_t i = 0; i < rough.size(); ++i) {
        flips += rough[i].status != reference[i].status;
        const double *q = reference[i].q, *v = reference[i].v;
        const double b = std::hypot(q[1] * v[2] - q[2] * v[1], q[2] * v[0] - q[0] * v[2], q[0] * v[1] - q[1] * v[0]);
        if (rough[i].status != Status::escaped || reference[i].status != Status::escaped || b < 1.2 * critical_impact)
            continue;
        errors.push_back(distance(rough[i].q, {q[0], q[1], q[2]}));
    }
    trial.expect(flips <= 2, std::to_string(flips) + " rays end otherwise, " + method + ", step " + number(step));
    std::sort(errors.begin(), errors.end());
    return errors;
}

}  // namespace

// Every ray of a picture against the same ray in double with small steps. Gauss methods compensate their updates: more
// steps never make the middle ray worse, and of the worst hundredth, a few rays and much luck, no more than a factor of
// 4, where 32 times as many steps without compensation make 32 times the error. What others lose is told.
void float_floor(Trial& trial) {
    if (!trial.in_float()) return;
    Options exact = trial.options();
    exact.precision = Precision::float64;
    const auto reference = picture_ends(trial, exact, "gauss8", 0.05);
    for (const char* method : {"gauss8", "gauss12", "suzuki4-nine", "rk4"}) {
        const bool compensated = std::string(method).starts_with("gauss");
        double least[] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, greatest = 0;
        std::string told;
        for (const double step : {0.4, 0.2, 0.1, 0.05, 0.025, 0.0125}) {
            const auto errors = float_errors(trial, reference, method, step);
            trial.expect(!errors.empty(),
                         std::string("no ray ends as in double, ") + method + ", step " + number(step));
            if (errors.empty()) continue;
            constexpr double shares[] = {0.5, 0.9, 0.99};
            for (int k = 0; k < 3; ++k) {
                const double error = errors[static_cast<std::size_t>(shares[k] * double(errors.size() - 1))];
                // Four ulp of r = 50 are the luck of roundings.
                if (compensated)
                    trial.expect(error < (k == 0 ? 1 : 4) * least[k] + 4 * 0x1p-18,
                                 "error " + std::to_string(error) + " of " + number(shares[k]) + " at step " +
                                     number(step) + ", but " + std::to_string(least[k]) + " at a longer one, " +
                                     method);
                least[k] = std::min(least[k], error);
                if (k != 1) told += (k == 0 ? (told.empty() ? "" : ", ") : " … ") + three_digits(error);
            }
            greatest = errors.back();
        }
        if (compensated) trial.measure("greatest error at the shortest step", greatest, 1e-3);
        if (!trial.in_scalar())
            trial.note(std::string(method) + ", half … 99 % of the rays at steps 0.4 to 0.0125: " + told);
    }
}

}  // namespace kagero::stability
