#include "stability/holes.h"

#include "stability/orbits.h"

namespace kagero::stability {

namespace {

// Impact parameters in units of r_g. The critical value b_c is 2.598. Methods of low order shift b_c slightly, and
// an energy error of 3 % shifts b_c by about 3 %. Cases with coarse steps therefore use values at least 6 % from b_c.
constexpr double captured_impacts[] = {0, 0.1, 0.5, 1, 1.5, 2, 2.3, 2.5, 2.55};
constexpr double impacts_below_critical[] = {0, 0.1, 0.5, 1, 1.5, 2, 2.3, 2.44};
constexpr double impacts_above_critical[] = {2.76, 3, 3.2, 4, 5, 7, 10, 15};

/// Returns inward rays that start at `radius`, one for each plane and impact parameter.
template <std::size_t n>
std::vector<RayInput> ray_fan(const double (&impacts)[n], double radius) {
    std::vector<RayInput> rays;
    for (const OrbitPlane& plane : planes)
        for (const double b : impacts) rays.push_back(ray_inward(plane, b, radius));
    return rays;
}

/// Traces one ray for each plane and impact parameter. Each must have the expected status or fail with a reason. At
/// most the share `max_failed` of the rays may fail. `settings` describes method and step in messages.
template <std::size_t n>
void expect_status_or_failure(CaseRun& run, const Plan& plan, const double (&impacts)[n], Status expected,
                              double max_failed, const std::string& settings) {
    const auto ends = run.ends(plan, ray_fan(impacts, 18));
    double failed_share = 0;
    for (std::size_t i = 0; i < ends.size(); ++i)
        if (ends[i].status == Status::failed) failed_share += 1 / double(ends.size());
        else run.expect_status(ends[i], expected, "b = " + number(impacts[i % n]) + ", " + settings);
    run.measure("percentage of failed rays", 100 * failed_share, 100 * max_failed);
}

}  // namespace

void captured_stay(CaseRun& run) {
    for (const char* method : {"verlet", "satoh4-nine", "suzuki4-nine", "ks-s10", "gauss8", "rk4", "dp54"})
        for (const char* rescale : {"auto", "none"})
            for (const double step : {0.01, 0.05}) {
                // satoh4-nine has an error of first order in the step.
                if (step > 0.01 && std::string(method).starts_with("satoh")) continue;
                const std::string settings = std::string(method) + ", step " + number(step) + ", rescale " + rescale;
                const std::string integrator = std::string("rescale = \"") + rescale + "\"";
                const auto plan = run.plan(hole_scene_text(method, step, integrator));
                for (const RayEnd& end : run.ends(plan, ray_fan(captured_impacts, 18)))
                    run.expect_status(end, Status::captured, settings);
            }
}

// H is the same for (p, p_t) and (−p, −p_t). Reversing an outward ray gives an inward ray with p_t = −1. Such a ray
// cannot cross the horizon in these coordinates and approaches it asymptotically.
void wrong_time_momentum(CaseRun& run) {
    for (const char* method : {"gauss8", "suzuki4-nine", "ks-s10", "rk4", "dp54"}) {
        const auto plan = run.plan(hole_scene_text(method, 0.1));
        std::vector<RayInput> rays;
        for (const OrbitPlane& plane : planes)
            for (const double slope : {0.0, 0.05, 0.1}) {
                RayInput ray{};
                for (std::size_t k = 0; k < 3; ++k) {
                    ray.position[k] = 15 * plane.outward[k];
                    ray.direction[k] = plane.outward[k] + slope * plane.across[k];
                }
                rays.push_back(ray);
            }
        auto starts = start_rays(plan, rays);
        for (RayStart& start : starts) {
            start.pt = -start.pt;
            for (double& p : start.p) p = -p;
        }
        for (const RayEnd& end : run.ends(plan, starts)) {
            run.expect_status(end, Status::captured, method);
            run.expect(end.steps <= 1000, std::to_string(end.steps) + " steps, " + method);
        }
    }
}

/// A method and the greatest shares of its rays that may fail.
struct Method {
    const char* name;
    double max_failed;               ///< Without time rescaling.
    double max_failed_rescaled = 0;  ///< With time rescaling.
};

void unsolvable_step(CaseRun& run) {
    constexpr Method methods[] = {{"midpoint", 0.75},     {"verlet", 0.75}, {"yoshida4", 0.5}, {"gauss4", 0.375},
                                  {"suzuki4-nine", 0.25}, {"s10", 0},       {"gauss8", 0},     {"gauss16", 0}};
    for (const auto& [method, max_failed, _] : methods)
        for (const double step : {1.0, 3.0, 10.0, 100.0, 1000.0}) {
            const std::string settings = std::string(method) + ", step " + number(step);
            Options options = run.options();
            options.energy_error = true;
            const auto plan =
                make_plan(run.scene(hole_scene_text(method, step, "rescale = \"none\"")), options, Purpose::ray_list);
            expect_status_or_failure(run, plan, impacts_below_critical, Status::captured, max_failed, settings);
            expect_status_or_failure(run, plan, impacts_above_critical, Status::escaped, max_failed, settings);
            for (const RayEnd& end : run.ends(plan, ray_fan(impacts_above_critical, 18)))
                if (end.status == Status::escaped) run.measure("energy error", end.energy_error, 0.04);
        }
}

void coarse_steps(CaseRun& run) {
    constexpr Method methods[] = {{"midpoint", 0.75}, {"verlet", 0.5, 0.125}, {"rk4", 0.5},     {"dp5", 0.5},
                                  {"gauss4", 0.375},  {"suzuki4-nine", 0.25}, {"kahan-li8", 0}, {"s10", 0},
                                  {"ks-s10", 0},      {"gauss8", 0},          {"gauss16", 0}};
    for (const auto& [method, max_failed, max_failed_rescaled] : methods)
        for (const char* rescale : {"auto", "none"}) {
            const std::string settings = std::string(method) + ", rescale " + rescale;
            const auto plan = run.plan(hole_scene_text(method, 50, std::string("rescale = \"") + rescale + "\""));
            const double max_share = rescale == std::string("auto") ? max_failed_rescaled : max_failed;
            expect_status_or_failure(run, plan, impacts_below_critical, Status::captured, max_share, settings);
            expect_status_or_failure(run, plan, impacts_above_critical, Status::escaped, max_share, settings);
        }
    // Methods in the orbit plane split long steps, so that hits agree with those of short steps.
    const std::string enclosing_sphere =
        "[[object]]\nname = \"wall\"\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 19\n";
    for (const char* method : {"orbit-srkn6", "orbit-srkn11", "orbit-srkn14"}) {
        const auto sphere_hits = [&](double step) {
            const auto plan_with_sphere = run.plan(hole_scene_text(method, step) + enclosing_sphere);
            return run.ends(plan_with_sphere, ray_fan(impacts_above_critical, 18));
        };
        const auto plan = run.plan(hole_scene_text(method, 1000));
        expect_status_or_failure(run, plan, impacts_below_critical, Status::captured, 0, method);
        expect_status_or_failure(run, plan, impacts_above_critical, Status::escaped, 0, method);
        const auto coarse = sphere_hits(1000), fine = sphere_hits(0.1);
        for (std::size_t i = 0; i < fine.size(); ++i) {
            run.expect_status(coarse[i], Status::hit, std::string("the enclosing sphere, ") + method);
            run.measure("distance of hits on the enclosing sphere from those of short steps",
                        distance(coarse[i].q, {fine[i].q[0], fine[i].q[1], fine[i].q[2]}), 0.1);
        }
    }
}

}  // namespace kagero::stability
