#include "stability/scenes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace kagero::stability {

void unusable_input(Trial& trial) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinite = HUGE_VAL;
    for (const char* hamiltonian : {"schwarzschild", "fisheye", "mirage"}) {
        const auto plan = trial.plan(space_text(hamiltonian, "", "escape_radius = 50"));
        const Double3 bad[] = {{0, 0, 0}, {nan, 0, 1}, {infinite, 0, 0}, {0, -infinite, 1}};
        std::vector<RayInput> rays;
        for (const Double3& d : bad) rays.push_back({{3, 0, 0}, d});
        for (const Double3& q : {Double3{nan, 0, 0}, Double3{0, infinite, 0}}) rays.push_back({q, {1, 0, 0}});
        for (const RayEnd& end : trial.ends(plan, rays)) {
            trial.expect_status(end, Status::failed, hamiltonian);
            trial.expect(end.steps == 0, std::string("steps from an unusable start, ") + hamiltonian);
        }
        // A good ray among bad ones is as it is alone, to the last bit.
        const RayInput good{{0.7, 0, 0.3}, {0.1, 1, 0.1}};
        const auto alone = trial.ends(plan, {good});
        rays.insert(rays.begin() + 2, good);
        const auto among = trial.ends(plan, rays);
        trial.expect(among[2].status == alone[0].status && std::equal(among[2].q, among[2].q + 3, alone[0].q),
                     std::string("a bad ray changes its neighbour, ") + hamiltonian);
    }
    const auto hole = trial.plan(space_text("schwarzschild", "rg = 1.0", "escape_radius = 50"));
    for (const double far : {1e3, 1e10, 1e30, 1e100, 1e300})
        trial.expect_status(trial.ends(hole, {RayInput{{far, 0, far / 3}, {1, 0.1, 0}}})[0], Status::escaped,
                            "a start at " + number(far) + ", outward");
    const std::string view =
        space_text("flat", "", "") +
        "[camera]\nposition = [0, -10, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [4, 4]\n";
    trial.expect(!trial.refusal(view + rectangle("line", {0, 0, 0}, {1, 0, 0}, {2, 0, 0})).empty(),
                 "a rectangle without area is accepted");
    trial.expect(!trial.refusal(view + rectangle("point", {0, 0, 0}, {0, 0, 0}, {0, 0, 1})).empty(),
                 "a rectangle of one edge is accepted");
}

// A floor at z = 0; and walls beside a fibre, where rays swing: with N² = n0² (1 − α² r²), and a ray that starts on the
// axis at an angle θ to it, x = A sin(α z / cos θ), A = sin θ / α. Of two walls, closer than A to the axis and farther
// by as little, one is met and one is not; both ends of a step that leads there lie before it.
void grazing(Trial& trial) {
    const auto plan = trial.plan(space_text("flat", "", "escape_radius = 300") +
                                 rectangle("floor", {-100, -100, 0}, {200, 0, 0}, {0, 200, 0}));
    for (const double slope : {1e-1, 1e-2, 1e-3, 1e-4}) {
        const double height = 50 * slope;
        const RayEnd down = trial.ends(plan, {RayInput{{-10, 0.3, height}, {1, 0, -slope}}})[0];
        trial.expect_status(down, Status::hit, "slope " + number(slope));
        trial.measure("hit off by (of 50, times slope)", std::abs(down.q[0] - 40) * slope,
                      trial.in_float() ? 1e-4 : 1e-5);
        const RayEnd along = trial.ends(plan, {RayInput{{-10, 0.3, height}, {1, 0, 0}}})[0];
        trial.expect_status(along, Status::escaped, "parallel at " + number(height));
        const RayEnd past = trial.ends(plan, {RayInput{{-10, 0.3, height}, {1, 0, -0.3 * slope}}})[0];
        trial.expect_status(past, Status::escaped, "past the floor's edge, slope " + number(slope));
    }
    constexpr double alpha = 0.3;
    for (const char* method : {"srkn6", "gauss8", "rk4", "dp8"})
        for (const double step : {0.05, 0.5})
            for (const double part : {1e-2, trial.in_float() ? 1e-3 : 1e-4})
                for (const double angle : {0.3, 0.6}) {
                    const double swing = std::sin(angle) / alpha;
                    for (const double side : {1.0, -1.0}) {
                        const double wall = swing * (1 - side * part);
                        const std::string integrator =
                            std::string("method = \"") + method + "\"\nescape_radius = 60\nstep = " + number(step);
                        const auto fiber = trial.plan(space_text("fiber", "alpha = " + number(alpha), integrator) +
                                                      rectangle("wall", {wall, -1, -1}, {0, 2, 0}, {0, 0, 8}));
                        const RayEnd end =
                            trial.ends(fiber, {RayInput{{0, 0, 0}, {std::sin(angle), 0, std::cos(angle)}}})[0];
                        trial.expect_status(end, side > 0 ? Status::hit : Status::escaped,
                                            "a wall " + number(part) + (side > 0 ? " inside" : " outside") + ", " +
                                                method + ", step " + number(step));
                        if (side < 0) continue;
                        const double place = std::cos(angle) * std::asin(1 - part) / alpha;
                        trial.measure("hit off by (times slope)", std::abs(end.q[2] - place) * std::sqrt(2 * part),
                                      trial.in_float() ? 1e-3 : 1e-4);
                    }
                }
}

namespace {

/// What a straight ray from the eye meets of the scene of `straight_picture`: 0 the plate, 1 the ball, −1 nothing.
struct Sight {
    int object = -1;
    double away = HUGE_VAL;
};

constexpr Double3 eye{0.1, -6, 0.4};

Sight look(const Double3& d) {
    Sight sight;
    const double to_plate = (1.5 - eye[1]) / d[1], x = eye[0] + to_plate * d[0], z = eye[2] + to_plate * d[2];
    if (to_plate > 0 && std::abs(x) < 1.2 && std::abs(z) < 0.9) sight = {0, to_plate};
    const Double3 ball{-0.6, 0, 0.5}, from{eye[0] - ball[0], eye[1] - ball[1], eye[2] - ball[2]};
    const double half = dot(from, d), root = half * half - dot(d, d) * (dot(from, from) - 0.49);
    if (root > 0 && (-half - std::sqrt(root)) / dot(d, d) < sight.away)
        sight = {1, (-half - std::sqrt(root)) / dot(d, d)};
    return sight;
}

Double3 direction(const CameraRays& c, double x, double y) {
    Double3 d{};
    for (std::size_t k = 0; k < 3; ++k) d[k] = c.corner[k] + x * c.right[k] + y * c.down[k];
    return d;
}

/// What the middle of a pixel shows; nothing where an edge is nearer than a thousandth of a pixel.
std::optional<Sight> certain_sight(const CameraRays& c, std::uint32_t x, std::uint32_t y) {
    const Sight middle = look(direction(c, x + 0.5, y + 0.5));
    for (const auto& [dx, dy] : {std::pair{1e-3, 0.0}, {-1e-3, 0.0}, {0.0, 1e-3}, {0.0, -1e-3}})
        if (look(direction(c, x + 0.5 + dx, y + 0.5 + dy)).object != middle.object) return {};
    return middle;
}

}  // namespace

void straight_picture(Trial& trial) {
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
        const auto plan = trial.plan(space_text(hamiltonian, parameters, "escape_radius = 30") + view, true);
        std::vector<RayStart> starts;
        for (std::uint32_t y = 0; y < 48; ++y)
            for (std::uint32_t x = 0; x < 48; ++x) starts.push_back(pixel_ray(plan, x, y));
        const auto ends = trial.ends(plan, starts);
        for (std::uint32_t i = 0; i < ends.size(); ++i) {
            const auto sight = certain_sight(plan.view.camera, i % 48, i / 48);
            if (!sight) continue;
            const std::string pixel =
                std::string(hamiltonian) + ", pixel " + std::to_string(i % 48) + "," + std::to_string(i / 48);
            trial.expect_status(ends[i], sight->object < 0 ? Status::escaped : Status::hit, pixel);
            if (sight->object < 0 || ends[i].status != Status::hit) continue;
            trial.expect(ends[i].surface == static_cast<std::uint32_t>(sight->object),
                         "wrong object, " + pixel);
            Double3 at = direction(plan.view.camera, i % 48 + 0.5, i / 48 + 0.5);
            for (std::size_t k = 0; k < 3; ++k) at[k] = eye[k] + sight->away * at[k];
            trial.measure("hit off by", distance(ends[i].q, at), trial.in_float() ? 1e-3 : 1e-9);
        }
    }
}

}  // namespace kagero::stability
