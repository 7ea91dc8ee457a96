// Numbers at the edges of their range, and the number of digits.
#include "stability/cases.h"
#include "stability/orbits.h"

#include <algorithm>
#include <cmath>

namespace kagero::stability {

namespace {

constexpr double impacts[] = {0.5, 2, 2.5, 2.7, 3, 5, 10};

std::vector<RayInput> fan(double scale) {
    std::vector<RayInput> rays;
    for (const OrbitPlane& plane : planes)
        for (const double b : impacts) {
            rays.push_back(ray_inward(plane, b, 18));
            for (double& x : rays.back().position) x *= scale;
        }
    return rays;
}

}  // namespace

void scaled_scene(Trial& trial) {
    const auto at = [&](double scale) {
        SceneDescription scene = trial.scene(hole("gauss8", 0.1));
        scene.space.parameters[0].second *= scale;
        scene.integrator.escape_radius *= scale;
        for (double& x : scene.camera.position) x *= scale;
        const auto plan = make_plan(std::move(scene), trial.options(), false);
        return trial.ends(*plan, fan(scale));
    };
    const auto plain = at(1);
    for (const double scale : {1e-30, 1e30}) {
        const auto ends = at(scale);
        for (std::size_t i = 0; i < ends.size(); ++i) {
            const std::string ray = "scale " + number(scale) + ", b = " + number(impacts[i % std::size(impacts)]);
            trial.expect_status(ends[i], plain[i].status, ray);
            if (ends[i].status != Status::escaped || plain[i].status != Status::escaped) continue;
            trial.measure("change of direction", distance(ends[i].v, {plain[i].v[0], plain[i].v[1], plain[i].v[2]}),
                          trial.in_float() ? 1e-4 : 1e-12);
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
            double best = HUGE_VAL;
            std::vector<RayEnd> ends;
            const auto starts = start_rays(*plan, rays(tiny), "");
            for (int i = 0; i < 3; ++i) best = std::min(best, trace(*plan, starts, ends).seconds);
            return best;
        };
        const auto plain = trial.ends(*plan, rays(0)), tiny = trial.ends(*plan, rays(small));
        for (std::size_t i = 0; i < plain.size(); ++i) {
            trial.expect_status(tiny[i], plain[i].status, method);
            trial.measure("difference", distance(tiny[i].q, {plain[i].q[0], plain[i].q[1], plain[i].q[2]}),
                          trial.in_float() ? 1e-5 : 1e-13);
        }
        trial.expect(seconds(small) < 20 * seconds(0), std::string("20 times slower with ") + method);
    }
}

// The end of each ray against the same ray in double with small steps, relative to r = 50.
void float_floor(Trial& trial) {
    if (!trial.in_float()) return;
    std::vector<RayInput> rays;
    for (const OrbitPlane& plane : planes)
        for (const double b : {3.0, 4.0, 5.0, 7.0, 10.0, 15.0}) rays.push_back(ray_inward(plane, b, 40));
    const auto ends = [&](const Options& options, double step) {
        SceneDescription scene = trial.scene(hole("gauss8", step));
        scene.integrator.escape_radius = 50;
        const auto plan = make_plan(std::move(scene), options, false);
        return trial.ends(*plan, rays);
    };
    Options exact = trial.options();
    exact.precision = "double";
    const auto reference = ends(exact, 0.05);
    double least = HUGE_VAL, greatest = 0;
    for (const double step : {0.4, 0.2, 0.1, 0.05, 0.025, 0.0125}) {
        const auto rough = ends(trial.options(), step);
        std::vector<double> errors;
        for (std::size_t i = 0; i < rough.size(); ++i) {
            trial.expect_status(rough[i], Status::escaped, "step " + number(step));
            errors.push_back(distance(rough[i].q, {reference[i].q[0], reference[i].q[1], reference[i].q[2]}));
        }
        std::sort(errors.begin(), errors.end());
        const double median = errors[errors.size() / 2];
        // Four ulp of r = 50 are the luck of roundings; the greatest error, of one ray, has more of it.
        trial.expect(median < least + 4 * 0x1p-18, "median error " + std::to_string(median) + " at step " + number(step) +
                                                       ", but " + std::to_string(least) + " at a longer one");
        trial.note("step " + std::to_string(step).substr(0, 6) + ": median " + std::to_string(median) + ", greatest " +
                   std::to_string(errors.back()));
        least = std::min(least, median), greatest = errors.back();
    }
    trial.measure("greatest error at the shortest step", greatest, 1e-3);
}

}  // namespace kagero::stability
