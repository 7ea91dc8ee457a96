#include "stability/media.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kagero::stability {

namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr double thicknesses[] = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6};

std::string layer(double thickness, const char* method) {
    return space_text("layer", "thickness = " + number(thickness),
                      std::string("method = \"") + method + "\"\ntolerance = 1e-10\nescape_radius = 50");
}

/// Angles to the normal below the layer; total reflection begins at asin(1/1.5) = 41.81 degrees.
constexpr double angles[] = {0, 10, 30, 40, 41.5, 42.5, 60, 80};

std::vector<RayInput> rays_from_below() {
    std::vector<RayInput> rays;
    for (const double angle : angles)
        rays.push_back({{0, 0, -3}, {std::sin(angle * degree), 0, std::cos(angle * degree)}});
    return rays;
}

constexpr const char* layer_methods[] = {"srkn6", "gauss8", "rk4", "dp54"};

}  // namespace

// Snell: p_x = n_below sin(angle) on both sides, p_z² = n² − p_x².
void layer_refraction(Trial& trial) {
    for (const char* method : layer_methods)
        for (const double thickness : thicknesses) {
            const auto plan = trial.plan(layer(thickness, method));
            const auto ends = trial.ends(plan, rays_from_below());
            for (std::size_t i = 0; i < ends.size(); ++i) {
                const std::string ray =
                    std::to_string(angles[i]) + " degrees, d = " + number(thickness) + ", " + method;
                trial.expect_status(ends[i], Status::escaped, ray);
                const double px = 1.5 * std::sin(angles[i] * degree);
                const bool through = px < 1;
                trial.expect((ends[i].v[2] > 0) == through, ray + (through ? " is reflected" : " is transmitted"));
                const double n = through ? 1 : 1.5;
                const Double3 v{px / n, 0, (through ? 1 : -1) * std::sqrt(1 - px * px / (n * n))};
                if (thickness < 1e-3 || (ends[i].v[2] > 0) != through) continue;
                trial.measure("direction error", distance(ends[i].v, v), trial.in_float() ? HUGE_VAL : 1e-6);
            }
        }
}

void layer_momentum(Trial& trial) {
    const double ulp = trial.in_float() ? 0x1p-23 : 0x1p-52;
    for (const char* method : layer_methods)
        for (const double thickness : thicknesses) {
            const auto plan = trial.plan(layer(thickness, method));
            const auto starts = start_rays(plan, rays_from_below());
            const auto ends = trial.ends(plan, starts);
            for (std::size_t i = 0; i < ends.size(); ++i)
                trial.measure("change in ulp", std::abs(ends[i].p[0] - starts[i].p[0]) / ulp, 8);
        }
}

namespace {

/// Greatest error of direction and parameter behind a Luneburg lens of radius 1. A ray that comes along z at distance x
/// from the axis is an arc of an ellipse, q = q0 cos τ + p0 sin τ, which ends at τ = π/2 in the focus (0, 0, 1) with p
/// = −q0: from there it goes straight on. Gauss methods keep the ellipse exactly, so the parameter has to tell their
/// order.
double lens_error(Trial& trial, const char* method, double step) {
    const auto plan =
        trial.plan(space_text("luneburg", "",
                              std::string("method = \"") + method + "\"\nescape_radius = 4\nstep = " + number(step)));
    const double offsets[] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8};
    std::vector<RayInput> rays;
    for (const double x : offsets) rays.push_back({{x, 0, -3}, {0, 0, 1}});
    const auto ends = trial.ends(plan, rays);
    double worst = 0;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        trial.expect_status(ends[i], Status::escaped, "x = " + number(offsets[i]));
        const double root = std::sqrt(1 - offsets[i] * offsets[i]),
                     outside = std::sqrt(15 + root * root) - root;  // to r = 4
        const double parameter = (3 - root) + std::numbers::pi / 2 + outside;
        worst = std::max(worst, distance(ends[i].v, {-offsets[i], 0, root}));
        worst = std::max(worst, std::abs(ends[i].parameter - parameter));
    }
    return worst;
}

}  // namespace

void lens_surface(Trial& trial) {
    const std::string served[] = {"midpoint", "gauss4", "gauss6", "gauss8", "gauss12", "gauss16"};
    const auto plan = trial.plan(space_text("luneburg", "", "escape_radius = 4"));
    for (std::uint32_t i = 0; i < plan.module().integrator_count; ++i) {
        const IntegratorInfo& info = plan.module().integrators[i];
        if (std::find(std::begin(served), std::end(served), info.name) == std::end(served)) {
            trial.expect(refusal_of(*plan.scene, i, false), std::string(info.name) + " is not refused");
            continue;
        }
        if (trial.in_float()) {
            if (info.order >= 4)
                trial.measure("error of direction and parameter", lens_error(trial, info.name, 0.1), 1e-5);
            continue;
        }
        // Half an order is left to the last step before the surface, whose length is anything. High orders soon reach
        // rounding.
        constexpr double rounding = 1e-12;
        const double step = info.order < 4 ? 0.2 : 0.4;
        const double coarse = lens_error(trial, info.name, step), fine = lens_error(trial, info.name, step / 4);
        const double measured = std::log2(coarse / fine) / 2;
        trial.expect(measured > info.order - 0.5 || fine < rounding,
                     std::string(info.name) + " has order " + std::to_string(measured));
        if (!trial.in_scalar() && fine > rounding)
            trial.note(std::string(info.name) + " has order " + std::to_string(measured).substr(0, 4));
    }
}

// The paper's mirage upward: n falls to zero near z = 1.4. A linear index: the vertical ray stops where N = 0 and falls
// back.
void vanishing_index(Trial& trial) {
    for (const char* method : {"srkn6", "gauss8", "rk4", "verlet"})
        for (const char* least : {"1e-2", "1e-6", "1e-12"}) {
            const std::string integrator = std::string("method = \"") + method + "\"\nescape_radius = 100";
            const auto mirage = trial.plan(space_text("mirage", std::string("n_min = ") + least, integrator));
            std::vector<RayInput> rays;
            for (const double angle : {5.0, 20.0, 45.0, 80.0, 90.0})
                rays.push_back({{0, 0, 0.5}, {std::cos(angle * degree), 0, std::sin(angle * degree)}});
            for (const RayEnd& end : trial.ends(mirage, rays)) {
                trial.expect(end.status == Status::escaped || end.status == Status::failed,
                             std::string(name_of(end.status)) + " in the mirage, " + method + ", n_min = " + least);
                trial.expect(end.status == Status::failed || end.q[2] < 1.5,
                             std::string("a ray goes where n < 0, ") + method);
            }
            const auto thrown = trial.plan(space_text("gradient", "g = 0.5", integrator));
            const RayEnd back = trial.ends(thrown, {RayInput{{0, 0, 0}, {0, 0, 1}}})[0];
            trial.expect(back.status == Status::failed || (back.status == Status::escaped && back.q[2] < 0),
                         std::string(name_of(back.status)) + " instead of turned back, " + method);
            const RayEnd none = trial.ends(thrown, {RayInput{{0, 0, 3}, {0, 0, 1}}})[0];
            trial.expect_status(none, Status::failed, "a start where N^2 < 0");
        }
}

namespace {

/// Sums of H over the first and the last tenth of a path.
struct Tenths {
    std::uint32_t steps;
    double first = 0, last = 0;
    std::uint32_t in_first = 0, in_last = 0;
};

/// Mean H of the last tenth less that of the first.
double drift(Trial& trial, const char* hamiltonian, const RayInput& ray, const char* method) {
    constexpr std::uint32_t steps = 1000000;
    const auto plan = trial.plan(space_text(hamiltonian, "",
                                            std::string("method = \"") + method +
                                                "\"\nescape_radius = 1e9\nmax_steps = " + std::to_string(steps)));
    Tenths tenths{steps};
    std::vector<RayEnd> ends;
    trace_steps(plan, start_rays(plan, {ray}), ends, [&](const PathPoint& point) {
        if (point.step < steps / 10) tenths.first += point.energy, ++tenths.in_first;
        if (point.step >= steps - steps / 10) tenths.last += point.energy, ++tenths.in_last;
    });
    const RayEnd& end = ends[0];
    trial.expect_status(end, Status::step_limit, std::string(hamiltonian) + ", " + method);
    return std::abs(tenths.last / tenths.in_last - tenths.first / tenths.in_first);
}

}  // namespace

void long_fiber(Trial& trial) {
    const RayInput swinging{{1, 0, 0}, {0, 0.2, 1}}, circling{{0.8, 0, 0}, {0.1, 1, 0}};
    for (const auto& [hamiltonian, ray] : {std::pair{"fiber", swinging}, std::pair{"fisheye", circling}}) {
        trial.measure(std::string("drift of srkn6 in the ") + hamiltonian, drift(trial, hamiltonian, ray, "srkn6"),
                      trial.in_float() ? 1e-3 : 1e-10);
        trial.measure(std::string("drift of rk4 in the ") + hamiltonian, drift(trial, hamiltonian, ray, "rk4"),
                      HUGE_VAL);
    }
}

void trapped(Trial& trial) {
    for (const char* method : {"srkn6", "gauss8", "suzuki4-nine", "rk4"}) {
        const auto plan =
            trial.plan(space_text("fisheye", "",
                                  std::string("method = \"") + method + "\"\nescape_radius = 10\nmax_steps = 3000"));
        std::vector<RayInput> rays;
        for (int i = 0; i < 20; ++i)
            rays.push_back({{0.1 + 0.05 * i, 0, 0}, {std::cos(0.3 * i), std::sin(0.3 * i), 0.2}});
        const auto once = trial.ends(plan, rays), again = trial.ends(plan, rays);
        for (std::size_t i = 0; i < once.size(); ++i) {
            const std::string ray = "ray " + std::to_string(i) + ", " + method;
            trial.expect_status(once[i], Status::step_limit, ray);
            trial.expect(once[i].steps == 3000, std::to_string(once[i].steps) + " steps at " + ray);
            trial.expect(distance(once[i].q, {again[i].q[0], again[i].q[1], again[i].q[2]}) == 0,
                         "not twice the same at " + ray);
        }
    }
}

}  // namespace kagero::stability
