#include "stability/scenes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace kagero::stability {

void unusable_input(CaseRun& run) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = HUGE_VAL;
    for (const char* hamiltonian : {"schwarzschild", "fisheye", "mirage"}) {
        const auto plan = run.plan(space_text(hamiltonian, "", "escape_radius = 50"));
        const Double3 invalid[] = {{0, 0, 0}, {nan, 0, 1}, {infinity, 0, 0}, {0, -infinity, 1}};
        std::vector<RayInput> rays;
        for (const Double3& d : invalid) rays.push_back({{3, 0, 0}, d});
        for (const Double3& q : {Double3{nan, 0, 0}, Double3{0, infinity, 0}}) rays.push_back({q, {1, 0, 0}});
        for (const RayEnd& end : run.ends(plan, rays)) {
            run.expect_status(end, Status::failed, hamiltonian);
            run.expect(end.steps == 0, std::string("the ray takes steps from an invalid start, ") + hamiltonian);
        }
        // A valid ray among invalid ones has the same end, bit for bit, as when it is traced alone.
        const RayInput valid{{0.7, 0, 0.3}, {0.1, 1, 0.1}};
        const auto alone = run.ends(plan, {valid});
        rays.insert(rays.begin() + 2, valid);
        const RayEnd among_invalid = run.ends(plan, rays)[2];
        run.expect(among_invalid.status == alone[0].status &&
                       std::equal(among_invalid.q, among_invalid.q + 3, alone[0].q),
                   std::string("an invalid ray changes the end of another ray, ") + hamiltonian);
    }
    const auto schwarzschild = run.plan(space_text("schwarzschild", "rg = 1.0", "escape_radius = 50"));
    for (const double start_x : {1e3, 1e10, 1e30, 1e100, 1e300})
        run.expect_status(run.ends(schwarzschild, {RayInput{{start_x, 0, start_x / 3}, {1, 0.1, 0}}})[0],
                          Status::escaped, "an outward ray from " + number(start_x));
    const std::string view =
        space_text("flat", "", "") +
        "[camera]\nposition = [0, -10, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [4, 4]\n";
    run.expect(!run.refusal(view + rectangle("line", {0, 0, 0}, {1, 0, 0}, {2, 0, 0})).empty(),
               "a rectangle with zero area is accepted");
    run.expect(!run.refusal(view + rectangle("point", {0, 0, 0}, {0, 0, 0}, {0, 0, 1})).empty(),
               "a rectangle with an edge of length zero is accepted");
}

// Two tests. First, straight rays meet a floor at z = 0 at small angles. Second, rays oscillate in a fibre with
// N² = n0² (1 − α² r²). A ray that starts on the axis at an angle θ follows x = A sin(α z / cos θ) with A = sin θ / α.
// A wall slightly closer to the axis than A is hit, and a wall slightly farther is not. Both ends of the step that
// reaches the wall may lie on the same side of it.
void grazing(CaseRun& run) {
    const auto plan = run.plan(space_text("flat", "", "escape_radius = 300") +
                               rectangle("floor", {-100, -100, 0}, {200, 0, 0}, {0, 200, 0}));
    for (const double slope : {1e-1, 1e-2, 1e-3, 1e-4}) {
        const double height = 50 * slope;
        const RayEnd down = run.ends(plan, {RayInput{{-10, 0.3, height}, {1, 0, -slope}}})[0];
        run.expect_status(down, Status::hit, "slope " + number(slope));
        run.measure("error of the hit after length 50, times slope", std::abs(down.q[0] - 40) * slope,
                    run.in_float() ? 1e-4 : 1e-5);
        const RayEnd along = run.ends(plan, {RayInput{{-10, 0.3, height}, {1, 0, 0}}})[0];
        run.expect_status(along, Status::escaped, "parallel at " + number(height));
        const RayEnd past = run.ends(plan, {RayInput{{-10, 0.3, height}, {1, 0, -0.3 * slope}}})[0];
        run.expect_status(past, Status::escaped, "beyond the edge of the floor, slope " + number(slope));
    }
    constexpr double alpha = 0.3;
    for (const char* method : {"srkn6", "gauss8", "rk4", "dp8"})
        for (const double step : {0.05, 0.5})
            for (const double deviation : {1e-2, run.in_float() ? 1e-3 : 1e-4})
                for (const double angle : {0.3, 0.6}) {
                    const double amplitude = std::sin(angle) / alpha;
                    for (const double sign : {1.0, -1.0}) {
                        const double wall = amplitude * (1 - sign * deviation);
                        const std::string integrator =
                            std::string("method = \"") + method + "\"\nescape_radius = 60\nstep = " + number(step);
                        const auto fiber = run.plan(space_text("fiber", "alpha = " + number(alpha), integrator) +
                                                    rectangle("wall", {wall, -1, -1}, {0, 2, 0}, {0, 0, 8}));
                        const RayEnd end =
                            run.ends(fiber, {RayInput{{0, 0, 0}, {std::sin(angle), 0, std::cos(angle)}}})[0];
                        run.expect_status(end, sign > 0 ? Status::hit : Status::escaped,
                                          "a wall " + number(deviation) + (sign > 0 ? " inside" : " outside") + ", " +
                                              method + ", step " + number(step));
                        if (sign < 0) continue;
                        const double expected_z = std::cos(angle) * std::asin(1 - deviation) / alpha;
                        run.measure("error of the hit, times slope",
                                    std::abs(end.q[2] - expected_z) * std::sqrt(2 * deviation),
                                    run.in_float() ? 1e-3 : 1e-4);
                    }
                }
}

namespace {

/// First hit of a straight camera ray in the scene of `straight_picture`.
struct StraightHit {
    int object = -1;              ///< 0: the plate; 1: the ball; −1: no hit.
    double parameter = HUGE_VAL;  ///< Parameter t of the hit point eye + t d, where d is the direction of the ray.
};

constexpr Double3 eye{0.1, -6, 0.4};

/// Intersects the camera ray of direction d with plate and ball in closed form.
StraightHit intersect(const Double3& d) {
    StraightHit hit;
    const double to_plate = (1.5 - eye[1]) / d[1], x = eye[0] + to_plate * d[0], z = eye[2] + to_plate * d[2];
    if (to_plate > 0 && std::abs(x) < 1.2 && std::abs(z) < 0.9) hit = {0, to_plate};
    const Double3 ball{-0.6, 0, 0.5}, offset{eye[0] - ball[0], eye[1] - ball[1], eye[2] - ball[2]};
    // A point of the ray at parameter t lies on the ball if d·d t² + 2 half_b t + offset·offset − 0.7² = 0.
    const double half_b = dot(offset, d);
    const double discriminant = half_b * half_b - dot(d, d) * (dot(offset, offset) - 0.49);
    if (discriminant > 0 && (-half_b - std::sqrt(discriminant)) / dot(d, d) < hit.parameter)
        hit = {1, (-half_b - std::sqrt(discriminant)) / dot(d, d)};
    return hit;
}

/// Returns the direction of the camera ray through the film position (x, y), in pixels.
Double3 direction(const CameraRays& c, double x, double y) {
    Double3 d{};
    for (std::size_t k = 0; k < 3; ++k) d[k] = c.corner[k] + x * c.right[k] + y * c.down[k];
    return d;
}

/// Returns the hit of the ray through a pixel centre, or nothing if an edge of an object is closer to it than a
/// thousandth of a pixel.
std::optional<StraightHit> hit_of_pixel(const CameraRays& c, std::uint32_t x, std::uint32_t y) {
    const StraightHit centre = intersect(direction(c, x + 0.5, y + 0.5));
    for (const auto& [dx, dy] : {std::pair{1e-3, 0.0}, {-1e-3, 0.0}, {0.0, 1e-3}, {0.0, -1e-3}})
        if (intersect(direction(c, x + 0.5 + dx, y + 0.5 + dy)).object != centre.object) return {};
    return centre;
}

}  // namespace

void straight_picture(CaseRun& run) {
    const std::string view =
        "[camera]\nposition = [0.1, -6.0, 0.4]\nlook_at = [0, 0, 0.3]\nup = [0, 0, 1]\nfov = 40.0\n[film]\nsize = [48, "
        "48]\n" +
        rectangle("plate", {-1.2, 1.5, -0.9}, {2.4, 0, 0}, {0, 0, 1.8}) +
        "[[object]]\nname = \"ball\"\nshape = \"sphere\"\ncenter = [-0.6, 0, 0.5]\nradius = 0.7\n";
    const std::pair<const char*, const char*> spaces[] = {{"flat", ""},
                                                          {"schwarzschild", "rg = 0.0"},
                                                          {"gradient", "n0 = 1.3\ng = 0.0"},
                                                          {"layer", "n_below = 1.2\nn_above = 1.2"},
                                                          {"mirage", "n0 = 1.0\nn3 = 0.0\nripple = 0.0"}};
    for (const auto& [hamiltonian, parameters] : spaces) {
        const auto plan = run.plan(space_text(hamiltonian, parameters, "escape_radius = 30") + view, true);
        std::vector<RayStart> starts;
        for (std::uint32_t y = 0; y < 48; ++y)
            for (std::uint32_t x = 0; x < 48; ++x) starts.push_back(pixel_ray_start(plan, x, y));
        const auto ends = run.ends(plan, starts);
        for (std::uint32_t i = 0; i < ends.size(); ++i) {
            const auto hit = hit_of_pixel(plan.view.camera, i % 48, i / 48);
            if (!hit) continue;
            const std::string pixel =
                std::string(hamiltonian) + ", pixel " + std::to_string(i % 48) + "," + std::to_string(i / 48);
            run.expect_status(ends[i], hit->object < 0 ? Status::escaped : Status::hit, pixel);
            if (hit->object < 0 || ends[i].status != Status::hit) continue;
            run.expect(ends[i].surface == static_cast<std::uint32_t>(hit->object),
                       "the ray hits the wrong object, " + pixel);
            Double3 exact = direction(plan.view.camera, i % 48 + 0.5, i / 48 + 0.5);
            for (std::size_t k = 0; k < 3; ++k) exact[k] = eye[k] + hit->parameter * exact[k];
            run.measure("distance of the hit from its exact position", distance(ends[i].q, exact),
                        run.in_float() ? 1e-3 : 1e-9);
        }
    }
}

}  // namespace kagero::stability
