#include "stability/holes.h"

#include "stability/orbits.h"

namespace kagero::stability {

namespace {

// b_c is 2.598. A method of low order moves it a little, and rays that may lose 3 % of H by as much: what is asked of
// rough steps is 6 % away from it.
constexpr double swallowed[] = {0, 0.1, 0.5, 1, 1.5, 2, 2.3, 2.5, 2.55};
constexpr double well_inside[] = {0, 0.1, 0.5, 1, 1.5, 2, 2.3, 2.44};
constexpr double well_outside[] = {2.76, 3, 3.2, 4, 5, 7, 10, 15};

template <std::size_t n>
std::vector<RayInput> fan(const double (&impacts)[n], double radius) {
    std::vector<RayInput> rays;
    for (const OrbitPlane& plane : planes)
        for (const double b : impacts) rays.push_back(ray_inward(plane, b, radius));
    return rays;
}

/// Every ray has its class, or has failed with a reason, as no greater share of them may than `most_failed`.
template <std::size_t n>
void expect_class_or_failure(Trial& trial, const Plan& plan, const double (&impacts)[n], Status expected,
                             double most_failed, const std::string& how) {
    const auto ends = trial.ends(plan, fan(impacts, 18));
    double failed = 0;
    for (std::size_t i = 0; i < ends.size(); ++i)
        if (ends[i].status == Status::failed) failed += 1 / double(ends.size());
        else trial.expect_status(ends[i], expected, "b = " + number(impacts[i % n]) + ", " + how);
    trial.measure("% of a fan that fail", 100 * failed, 100 * most_failed);
}

}  // namespace

void captured_stay(Trial& trial) {
    for (const char* method : {"verlet", "satoh4-nine", "suzuki4-nine", "ks-s10", "gauss8", "rk4", "dp54"})
        for (const char* rescale : {"auto", "none"})
            for (const double step : {0.01, 0.05}) {
                if (step > 0.01 && std::string(method).starts_with("satoh")) continue;  // of order 1
                const std::string how = std::string(method) + ", step " + number(step) + ", rescale " + rescale;
                const auto plan = trial.plan(hole(method, step, std::string("rescale = \"") + rescale + "\""));
                for (const RayEnd& end : trial.ends(plan, fan(swallowed, 18)))
                    trial.expect_status(end, Status::captured, how);
            }
}

// H is the same for (p, p_t) and (−p, −p_t), which moves backward: a ray outward, reversed, goes inward with p_t = −1.
// It cannot cross the horizon this way, and would creep up to it for ever.
void wrong_time_momentum(Trial& trial) {
    for (const char* method : {"gauss8", "suzuki4-nine", "ks-s10", "rk4", "dp54"}) {
        const auto plan = trial.plan(hole(method, 0.1));
        std::vector<RayInput> rays;
        for (const OrbitPlane& plane : planes)
            for (const double slope : {0.0, 0.05, 0.1}) {
                RayInput ray{};
                for (std::size_t k = 0; k < 3; ++k)
                    ray.position[k] = 15 * plane.outward[k],
                    ray.direction[k] = plane.outward[k] + slope * plane.across[k];
                rays.push_back(ray);
            }
        auto starts = start_rays(plan, rays);
        for (RayStart& start : starts) {
            start.pt = -start.pt;
            for (double& p : start.p) p = -p;
        }
        for (const RayEnd& end : trial.ends(plan, starts)) {
            trial.expect_status(end, Status::captured, method);
            trial.expect(end.steps <= 1000, std::to_string(end.steps) + " steps, " + method);
        }
    }
}

/// A method, and the greatest share of a fan that may fail by it.
struct Method {
    const char* name;
    double most_failed, rescaled = 0;  ///< the latter where H is rescaled
};

void unsolvable_step(Trial& trial) {
    constexpr Method methods[] = {{"midpoint", 0.75},     {"verlet", 0.75}, {"yoshida4", 0.5}, {"gauss4", 0.375},
                                  {"suzuki4-nine", 0.25}, {"s10", 0},       {"gauss8", 0},     {"gauss16", 0}};
    for (const auto& [method, most_failed, _] : methods)
        for (const double step : {1.0, 3.0, 10.0, 100.0, 1000.0}) {
            const std::string how = std::string(method) + ", step " + number(step);
            Options watched = trial.options();
            watched.energy_error = true;
            const auto plan =
                make_plan(trial.scene(hole(method, step, "rescale = \"none\"")), watched, Purpose::ray_list);
            expect_class_or_failure(trial, plan, well_inside, Status::captured, most_failed, how);
            expect_class_or_failure(trial, plan, well_outside, Status::escaped, most_failed, how);
            for (const RayEnd& end : trial.ends(plan, fan(well_outside, 18)))
                if (end.status == Status::escaped) trial.measure("H off by", end.energy_error, 0.04);
        }
}

void coarse_steps(Trial& trial) {
    constexpr Method methods[] = {{"midpoint", 0.75}, {"verlet", 0.5, 0.125}, {"rk4", 0.5},     {"dp5", 0.5},
                                  {"gauss4", 0.375},  {"suzuki4-nine", 0.25}, {"kahan-li8", 0}, {"s10", 0},
                                  {"ks-s10", 0},      {"gauss8", 0},          {"gauss16", 0}};
    for (const auto& [method, most_failed, most_failed_rescaled] : methods)
        for (const char* rescale : {"auto", "none"}) {
            const std::string how = std::string(method) + ", rescale " + rescale;
            const auto plan = trial.plan(hole(method, 50, std::string("rescale = \"") + rescale + "\""));
            const double most = rescale == std::string("auto") ? most_failed_rescaled : most_failed;
            expect_class_or_failure(trial, plan, well_inside, Status::captured, most, how);
            expect_class_or_failure(trial, plan, well_outside, Status::escaped, most, how);
        }
    // In the orbit plane steps are cut, so that what is met is what short steps meet.
    const std::string wall = "[[object]]\nname = \"wall\"\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 19\n";
    for (const char* method : {"orbit-srkn6", "orbit-srkn11", "orbit-srkn14"}) {
        const auto meets = [&](double step) {
            return trial.ends(trial.plan(hole(method, step) + wall), fan(well_outside, 18));
        };
        const auto plan = trial.plan(hole(method, 1000));
        expect_class_or_failure(trial, plan, well_inside, Status::captured, 0, method);
        expect_class_or_failure(trial, plan, well_outside, Status::escaped, 0, method);
        const auto coarse = meets(1000), fine = meets(0.1);
        for (std::size_t i = 0; i < fine.size(); ++i) {
            trial.expect_status(coarse[i], Status::hit, std::string("the wall around, ") + method);
            trial.measure("the wall around is met off by",
                          distance(coarse[i].q, {fine[i].q[0], fine[i].q[1], fine[i].q[2]}), 0.1);
        }
    }
}

}  // namespace kagero::stability
