/// Comparison of rays near a hole of mass 1 with the independent integration of kerr_geodesic.h.
#pragma once

#include "tests/support/kerr_geodesic.h"
#include "tests/support/plan_fixture.h"

#include <optional>

namespace kagero::test {

/// Default tolerance of `trace`: the local error of a step.
inline constexpr double default_tolerance = 1e-10;

/// The function whose zero ends a ray of the reference.
using Beyond = std::function<Real(const Real (&)[3])>;

/// Returns the function for the sphere |q| = radius.
inline Beyond beyond_sphere(Real radius) {
    return [radius](const Real(&q)[3]) { return std::hypot(q[0], q[1], q[2]) - radius; };
}
/// Returns the function for the cube whose edges have the length 2 size.
inline Beyond beyond_cube(Real size) {
    return [size](const Real(&q)[3]) { return std::max({std::abs(q[0]), std::abs(q[1]), std::abs(q[2])}) - size; };
}
/// Returns the object for the walls of that cube.
inline std::string walls(int size) {
    const std::string s = std::to_string(size);
    return "[[object]]\nname = \"walls\"\nshape = \"room\"\nmin = [-" + s + ", -" + s + ", -" + s + "]\nmax = [" + s +
           ", " + s + ", " + s + "]\n";
}

/// Returns the text of a scene with a hole of the given spin and mass 1. Without spin, the space is `schwarzschild`.
inline std::string scene_with_hole(double spin, const std::string& objects = "") {
    const std::string space = spin == 0 ? "hamiltonian = \"schwarzschild\", rg = 2"
                                        : "hamiltonian = \"kerr\", spin = " + std::to_string(spin);
    return "space = { " + space +
           " }\n[integrator]\nescape_radius = 40\n[camera]\nposition = [0, -10, 0]\nlook_at = [0, 0, 0]\n"
           "up = [0, 0, 1]\n[film]\nsize = [4, 4]\n" +
           objects;
}
/// Returns the plan of such a scene for a list of rays.
inline std::unique_ptr<Plan> plan_for_rays(const std::string& scene, const std::string& observer,
                                           const char* strategy = "packet") {
    Options options = with_strategy(strategy);
    options.observer = observer_of(observer);
    auto plan = plan_of_text(scene, {}, options, false);
    EXPECT_EQ(plan->scene->unit, 1);
    return plan;
}
inline std::vector<RayEnd> traced(const Plan& plan, const std::vector<RayStart>& starts) {
    std::vector<RayEnd> ends;
    trace(plan, starts, ends);
    return ends;
}

/// Returns unit vectors that are distributed evenly over all directions.
inline std::vector<Double3> even_directions(int count) {
    std::vector<Double3> directions;
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2 * i + 1.0) / count, s = std::sqrt(1 - z * z), angle = 2.399963229728653 * i;
        directions.push_back({s * std::cos(angle), s * std::sin(angle), z});
    }
    return directions;
}

/// Returns the position with the Boyer–Lindquist coordinates r and θ, and with the azimuth of (x, y).
inline Double3 position_at(double spin, double r, double theta, double azimuth) {
    const double rho = std::hypot(r, spin) * std::sin(theta);
    return {rho * std::cos(azimuth), rho * std::sin(azimuth), r * std::cos(theta)};
}

/// The state at the start of a ray in the coordinates of the scene: ingoing inside the horizon, else outgoing.
inline RayStart start_in_scene(const Plan& plan, RayStart start) {
    const Hole hole = plan.scene->space.hole();
    if (start.ingoing) plan.module().to_scene(&hole, start.q, start.p, &start.pt);
    return start;
}
/// Returns the reference for a ray.
inline KerrGeodesic geodesic_of(const Plan& plan, const RayStart& ray) {
    const Hole hole = plan.scene->space.hole();
    EXPECT_EQ(hole.mass, 1);
    const RayStart start = start_in_scene(plan, ray);
    const bool inside = plan.module().hole_radius(&hole, start.q) <= 1 + std::sqrt(1 - hole.spin * hole.spin);
    return KerrGeodesic(hole.spin, start.q, start.p, start.pt, inside);
}

/// Returns true if a change of the direction by 1e-6 decides whether the ray escapes.
inline bool is_critical(const KerrGeodesic& ray) {
    const bool escapes = ray.escape_margin() > 0;
    for (const int direction : {0, 1})
        for (const Real change : {-1e-6L, 1e-6L})
            if ((ray.turned(direction, change).escape_margin() > 0) != escapes) return true;
    return false;
}

/// Returns the distance of two ends: the greater one of the distances of the directions and of the positions relative
/// to |q|.
template <class End>
double distance_between(const KerrGeodesic::Place& a, const End& b) {
    const Real scale = std::hypot(a.q[0], a.q[1], a.q[2]);
    return double(std::max(std::hypot(a.q[0] - b.q[0], a.q[1] - b.q[1], a.q[2] - b.q[2]) / scale,
                           std::hypot(a.v[0] - b.v[0], a.v[1] - b.v[1], a.v[2] - b.v[2])));
}

/// The end of a ray by the reference, and its conditioning: the change of the end divided by a small change of the
/// direction at the start.
struct ReferenceEnd {
    KerrGeodesic::Place place;
    double conditioning;
};
/// Returns the reference end; nothing if the ray falls into the hole.
inline std::optional<ReferenceEnd> reference_end(const KerrGeodesic& ray, const Beyond& beyond) {
    constexpr Real longest_step = 0.1L, change = 1e-7L;
    ReferenceEnd end{{}, 1};
    if (!ray.follow(beyond, longest_step, end.place)) return std::nullopt;
    for (const int direction : {0, 1}) {
        KerrGeodesic::Place other;
        if (ray.turned(direction, change).follow(beyond, longest_step, other))
            end.conditioning += distance_between(end.place, other) / double(change);
    }
    return end;
}

}  // namespace kagero::test
