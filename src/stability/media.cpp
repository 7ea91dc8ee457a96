#include "stability/media.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kagero::stability {

namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr double thicknesses[] = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6};

/// Returns the scene text of a layer in which the index changes from 1.5 to 1 as tanh(z/thickness).
std::string layer_text(double thickness, const char* method) {
    return space_text("layer", "thickness = " + number(thickness),
                      std::string("method = \"") + method + "\"\ntolerance = 1e-10\nescape_radius = 50");
}

/// Angles of incidence from below the layer, degrees. Total reflection begins at asin(1/1.5) = 41.81 degrees.
constexpr double angles[] = {0, 10, 30, 40, 41.5, 42.5, 60, 80};

std::vector<RayInput> rays_from_below() {
    std::vector<RayInput> rays;
    for (const double angle : angles)
        rays.push_back({{0, 0, -3}, {std::sin(angle * degree), 0, std::cos(angle * degree)}});
    return rays;
}

constexpr const char* layer_methods[] = {"srkn6", "gauss8", "rk4", "dp54"};

}  // namespace

// Snell's law: p_x = n_below sin(angle) on both sides of the layer, and p_z² = n² − p_x².
void layer_refraction(CaseRun& run) {
    for (const char* method : layer_methods)
        for (const double thickness : thicknesses) {
            const auto plan = run.plan(layer_text(thickness, method));
            const auto ends = run.ends(plan, rays_from_below());
            for (std::size_t i = 0; i < ends.size(); ++i) {
                const std::string ray =
                    std::to_string(angles[i]) + " degrees, d = " + number(thickness) + ", " + method;
                run.expect_status(ends[i], Status::escaped, ray);
                const double px = 1.5 * std::sin(angles[i] * degree);
                const bool is_transmitted = px < 1;
                run.expect((ends[i].v[2] > 0) == is_transmitted,
                           ray + (is_transmitted ? " is reflected" : " is transmitted"));
                const double n = is_transmitted ? 1 : 1.5;
                const Double3 v{px / n, 0, (is_transmitted ? 1 : -1) * std::sqrt(1 - px * px / (n * n))};
                if (thickness < 1e-3 || (ends[i].v[2] > 0) != is_transmitted) continue;
                run.measure("direction error", distance(ends[i].v, v), run.in_float() ? HUGE_VAL : 1e-6);
            }
        }
}

void layer_momentum(CaseRun& run) {
    const double ulp = run.in_float() ? 0x1p-23 : 0x1p-52;
    for (const char* method : layer_methods)
        for (const double thickness : thicknesses) {
            const auto plan = run.plan(layer_text(thickness, method));
            const auto starts = start_rays(plan, rays_from_below());
            const auto ends = run.ends(plan, starts);
            for (std::size_t i = 0; i < ends.size(); ++i)
                run.measure("change of p_x in ulp", std::abs(ends[i].p[0] - starts[i].p[0]) / ulp, 8);
        }
}

namespace {

/// Returns the greatest error of direction and ray parameter λ behind a Luneburg lens of radius 1. The rays are
/// parallel to the z axis at distances x from it, and enter the lens at the point q0 with the momentum p0. Inside the
/// lens a ray is an arc of an ellipse, q = q0 cos s + p0 sin s, where s is λ minus its value at the entry. The ray
/// reaches the focus (0, 0, 1) at s = π/2 with p = −q0 and continues as a straight line. Gauss methods conserve the
/// ellipse exactly, so that only the error of λ shows their order.
double lens_error(CaseRun& run, const char* method, double step) {
    const auto plan =
        run.plan(space_text("luneburg", "",
                            std::string("method = \"") + method + "\"\nescape_radius = 4\nstep = " + number(step)));
    const double offsets[] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8};
    std::vector<RayInput> rays;
    for (const double x : offsets) rays.push_back({{x, 0, -3}, {0, 0, 1}});
    const auto ends = run.ends(plan, rays);
    double worst = 0;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        run.expect_status(ends[i], Status::escaped, "x = " + number(offsets[i]));
        // A ray enters the lens at z = −half_chord. From the focus to the escape sphere r = 4 its length is `outside`.
        const double half_chord = std::sqrt(1 - offsets[i] * offsets[i]);
        const double outside = std::sqrt(15 + half_chord * half_chord) - half_chord;
        const double parameter = (3 - half_chord) + std::numbers::pi / 2 + outside;
        worst = std::max(worst, distance(ends[i].v, {-offsets[i], 0, half_chord}));
        worst = std::max(worst, std::abs(ends[i].parameter - parameter));
    }
    return worst;
}

}  // namespace

void lens_surface(CaseRun& run) {
    const std::string supported[] = {"midpoint", "gauss4", "gauss6", "gauss8", "gauss12", "gauss16"};
    const auto plan = run.plan(space_text("luneburg", "", "escape_radius = 4"));
    for (std::uint32_t i = 0; i < plan.module().integrator_count; ++i) {
        const IntegratorInfo& info = plan.module().integrators[i];
        if (std::find(std::begin(supported), std::end(supported), info.name) == std::end(supported)) {
            run.expect(refusal_of(*plan.scene, i, false), std::string(info.name) + " is not refused");
            continue;
        }
        if (run.in_float()) {
            if (info.order >= 4) run.measure("error of direction and parameter", lens_error(run, info.name, 0.1), 1e-5);
            continue;
        }
        // The measured order may be lower by one half, because the last step before the surface has an arbitrary
        // length. The errors of methods of high order reach the level of rounding.
        constexpr double rounding = 1e-12;
        const double step = info.order < 4 ? 0.2 : 0.4;
        const double coarse = lens_error(run, info.name, step), fine = lens_error(run, info.name, step / 4);
        const double measured_order = std::log2(coarse / fine) / 2;
        run.expect(measured_order > info.order - 0.5 || fine < rounding,
                   std::string(info.name) + " has order " + std::to_string(measured_order));
        if (!run.is_scalar() && fine > rounding)
            run.note(std::string(info.name) + " has order " + std::to_string(measured_order).substr(0, 4));
    }
}

// Two media. In the mirage of Satoh (2003), n falls to zero near z = 1.4, and the rays run upward. In the space
// `gradient`, a vertical ray turns back at the height where N² = 0, with the index N.
void vanishing_index(CaseRun& run) {
    for (const char* method : {"srkn6", "gauss8", "rk4", "verlet"})
        for (const char* n_min : {"1e-2", "1e-6", "1e-12"}) {
            const std::string integrator = std::string("method = \"") + method + "\"\nescape_radius = 100";
            const auto mirage = run.plan(space_text("mirage", std::string("n_min = ") + n_min, integrator));
            std::vector<RayInput> rays;
            for (const double angle : {5.0, 20.0, 45.0, 80.0, 90.0})
                rays.push_back({{0, 0, 0.5}, {std::cos(angle * degree), 0, std::sin(angle * degree)}});
            for (const RayEnd& end : run.ends(mirage, rays)) {
                run.expect(end.status == Status::escaped || end.status == Status::failed,
                           std::string(name_of(end.status)) + " in the mirage, " + method + ", n_min = " + n_min);
                run.expect(end.status == Status::failed || end.q[2] < 1.5,
                           std::string("a ray reaches the region n < 0, ") + method);
            }
            const auto gradient = run.plan(space_text("gradient", "g = 0.5", integrator));
            const RayEnd returned = run.ends(gradient, {RayInput{{0, 0, 0}, {0, 0, 1}}})[0];
            run.expect(returned.status == Status::failed || (returned.status == Status::escaped && returned.q[2] < 0),
                       std::string(name_of(returned.status)) + " instead of a ray that turns back, " + method);
            const RayEnd outside = run.ends(gradient, {RayInput{{0, 0, 3}, {0, 0, 1}}})[0];
            run.expect_status(outside, Status::failed, "a ray start with N^2 < 0");
        }
}

namespace {

/// Sums and counts of H over the first and the last tenth of a path.
struct Tenths {
    double first_sum = 0, last_sum = 0;
    std::uint32_t first_count = 0, last_count = 0;
};

/// Returns the absolute difference between the means of H over the last and the first tenth of a path.
double energy_drift(CaseRun& run, const char* hamiltonian, const RayInput& ray, const char* method) {
    constexpr std::uint32_t steps = 1000000;
    const auto plan = run.plan(space_text(hamiltonian, "",
                                          std::string("method = \"") + method +
                                              "\"\nescape_radius = 1e9\nmax_steps = " + std::to_string(steps)));
    Tenths tenths;
    std::vector<RayEnd> ends;
    trace_steps(plan, start_rays(plan, {ray}), ends, [&](const PathPoint& point) {
        if (point.step < steps / 10) {
            tenths.first_sum += point.energy;
            ++tenths.first_count;
        }
        if (point.step >= steps - steps / 10) {
            tenths.last_sum += point.energy;
            ++tenths.last_count;
        }
    });
    const RayEnd& end = ends[0];
    run.expect_status(end, Status::step_limit, std::string(hamiltonian) + ", " + method);
    return std::abs(tenths.last_sum / tenths.last_count - tenths.first_sum / tenths.first_count);
}

}  // namespace

void long_fiber(CaseRun& run) {
    const RayInput oscillating{{1, 0, 0}, {0, 0.2, 1}}, circling{{0.8, 0, 0}, {0.1, 1, 0}};
    for (const auto& [hamiltonian, ray] : {std::pair{"fiber", oscillating}, std::pair{"fisheye", circling}}) {
        run.measure(std::string("drift of srkn6 in the ") + hamiltonian, energy_drift(run, hamiltonian, ray, "srkn6"),
                    run.in_float() ? 1e-3 : 1e-10);
        run.measure(std::string("drift of rk4 in the ") + hamiltonian, energy_drift(run, hamiltonian, ray, "rk4"),
                    HUGE_VAL);
    }
}

void trapped(CaseRun& run) {
    for (const char* method : {"srkn6", "gauss8", "suzuki4-nine", "rk4"}) {
        const auto plan =
            run.plan(space_text("fisheye", "",
                                std::string("method = \"") + method + "\"\nescape_radius = 10\nmax_steps = 3000"));
        std::vector<RayInput> rays;
        for (int i = 0; i < 20; ++i)
            rays.push_back({{0.1 + 0.05 * i, 0, 0}, {std::cos(0.3 * i), std::sin(0.3 * i), 0.2}});
        const auto first = run.ends(plan, rays), second = run.ends(plan, rays);
        for (std::size_t i = 0; i < first.size(); ++i) {
            const std::string ray = "ray " + std::to_string(i) + ", " + method;
            run.expect_status(first[i], Status::step_limit, ray);
            run.expect(first[i].steps == 3000, std::to_string(first[i].steps) + " steps at " + ray);
            run.expect(distance(first[i].q, {second[i].q[0], second[i].q[1], second[i].q[2]}) == 0,
                       "two runs differ at " + ray);
        }
    }
}

}  // namespace kagero::stability
