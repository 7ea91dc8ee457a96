#include "stability/critical.h"

#include "stability/orbits.h"

#include <cmath>
#include <numbers>

namespace kagero::stability {

std::string hole(const std::string& method, double step, const std::string& integrator) {
    return space_text("schwarzschild", "rg = 1.0",
                      "method = \"" + method + "\"\nstep = " + number(step) +
                          "\nescape_radius = 20\nmax_steps = 100000\n" + integrator);
}

namespace {

/// Angles swept by rays in the planes of the table, added up along their paths.
std::vector<double> swept_angles(const std::vector<PathPoint>& points, std::size_t rays) {
    std::vector<double> swept(rays, 0), last(rays, 0);
    for (const PathPoint& point : points) {
        const OrbitPlane& plane = planes[point.ray];
        const Double3 q{point.q[0], point.q[1], point.q[2]};
        const double angle = std::atan2(dot(q, plane.across), dot(q, plane.outward));
        swept[point.ray] += std::remainder(angle - last[point.ray], 2 * std::numbers::pi);
        last[point.ray] = angle;
    }
    return swept;
}

}  // namespace

namespace {

/// Rays of impact parameter b in all planes, which must wind `least` times: half of them towards r = 3/2 r_g, half away
/// from there, in or out.
void expect_windings(Trial& trial, double b, double least, const char* method) {
    std::vector<RayInput> rays;
    for (const OrbitPlane& plane : planes) rays.push_back(ray_inward(plane, b, 10));
    const auto plan = trial.plan(hole(method, std::string(method).starts_with("gauss") ? 0.04 : 0.02));
    trial.ends(plan, rays);
    std::vector<RayEnd> ends;
    const auto swept = swept_angles(trace_paths(plan, start_rays(plan, rays), ends), rays.size());
    for (std::size_t i = 0; i < ends.size(); ++i) {
        const std::string ray =
            "plane " + std::to_string(i) + ", b/b_c - 1 = " + number(b / critical_impact - 1) + ", " + method;
        trial.expect(ends[i].status == Status::captured || ends[i].status == Status::escaped,
                     std::string(name_of(ends[i].status)) + " at " + ray);
        // What a straight ray sweeps, on its way in and out or in alone, is no deflection.
        const double half = ends[i].status == Status::captured ? 0.5 : 1,
                     windings = 0.5 * (swept[i] / std::numbers::pi - half);
        trial.expect(windings >= least,
                     std::to_string(windings) + " windings, " + name_of(ends[i].status) + ", at " + ray);
        if (i == 0 && !trial.in_scalar())
            trial.note(std::to_string(windings).substr(0, 4) + " windings, " + name_of(ends[i].status) + ", " + method);
    }
}

}  // namespace

// The deflection is −ln(b/b_c − 1) − 0.40 (Luminet 1979): of rays that come back, those just above b_c wind as often as
// they should.
void photon_sphere(Trial& trial) {
    const double least = trial.in_float() ? 2 : 4, above = std::exp(-2 * std::numbers::pi * (least + 0.1) - 0.4);
    for (const double b : {critical_impact, critical_impact * (1 + above)})
        for (const char* method : {"gauss8", "gauss12", "gauss16", "kahan-li8", "s10", "ks-s10"}) {
            if (trial.in_float() && !std::string(method).starts_with("gauss"))
                continue;  // updates of the others are not compensated
            expect_windings(trial, b, least, method);
        }
}

void near_critical(Trial& trial) {
    for (const char* method : {"gauss8", "gauss12", "ks-s10", "kahan-li8", "suzuki4-nine"}) {
        const bool fourth = std::string(method) == "suzuki4-nine";
        const auto plan = trial.plan(hole(method, fourth ? 0.02 : 0.1));
        for (const double away : {1e-6, 1e-4, 1e-2}) {
            if (trial.in_float() && away < 1e-4) continue;
            for (const double side : {-1.0, 1.0}) {
                std::vector<RayInput> rays;
                for (const OrbitPlane& plane : planes)
                    rays.push_back(ray_inward(plane, critical_impact * (1 + side * away), 10));
                for (const RayEnd& end : trial.ends(plan, rays))
                    trial.expect_status(end, side < 0 ? Status::captured : Status::escaped,
                                        "b/b_c - 1 = " + number(side * away) + ", " + method);
            }
        }
    }
}

// A static observer sees the whole sky in a cone about the direction away from the hole: sin θ = b_c √(1 − 1/r)/r
// (Synge 1966).
void near_horizon(Trial& trial) {
    for (const double height : {1e-2, 1e-4, 1e-6}) {
        const double r = 1 + height, cone = std::asin(critical_impact * std::sqrt(1 - 1 / r) / r);
        const std::string at = "r - rg = " + number(height);
        const std::string refused =
            trial.refusal(hole("gauss8", 0.1) + "[camera]\nposition = [" + number(r) +
                          ", 0, 0]\nlook_at = [2, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [4, 4]\n");
        trial.expect(refused.empty() || trial.in_float(), refused);
        if (!refused.empty() && trial.in_float() && !trial.in_scalar()) trial.note("camera refused at " + at);
        const auto plan = trial.plan(hole("gauss8", 0.1));
        for (const double share : {0.5, 0.9, 1.1, 2.0}) {
            std::vector<RayInput> rays;
            for (int i = 0; i < 8; ++i) {
                const double around = i * std::numbers::pi / 4, angle = share * cone;
                rays.push_back(
                    {{r, 0, 0},
                     {std::cos(angle), std::sin(angle) * std::cos(around), std::sin(angle) * std::sin(around)}});
            }
            for (const RayEnd& end : trial.ends(plan, rays, ObserverKind::static_)) {
                if (trial.in_float() && end.status == Status::failed) continue;
                trial.expect_status(end, share < 1 ? Status::escaped : Status::captured,
                                    number(share) + " of the cone, " + at);
            }
        }
    }
}

void inside(Trial& trial) {
    const auto plan = trial.plan(hole("gauss8", 0.1));
    std::vector<Double3> directions;
    for (int i = 0; i < 27; ++i)
        if (i != 13) directions.push_back({i % 3 - 1.0, i / 3 % 3 - 1.0, i / 9 - 1.0});
    for (const double r : {1.0, 0.999999, 0.75, 0.5, 0.1}) {
        std::vector<RayInput> rays;
        for (const Double3& d : directions) rays.push_back({{r, 0, 0}, d});
        const std::string at = "r = " + number(r);
        const auto ends = trial.ends(plan, rays, ObserverKind::falling);
        for (std::size_t i = 0; i < ends.size(); ++i)
            trial.expect(ends[i].status == Status::escaped || ends[i].status == Status::captured,
                         std::string(name_of(ends[i].status)) + " (" + describe(ends[i].failure) +
                             ") for a falling observer at " + at);
        // Straight back out lies the sky from which it fell.
        trial.expect_status(trial.ends(plan, {RayInput{{r, 0, 0}, {1, 0, 0}}}, ObserverKind::falling)[0],
                            Status::escaped, "outward, " + at);
        for (const RayEnd& end : trial.ends(plan, rays, ObserverKind::static_))
            trial.expect(end.status == Status::failed,
                         std::string(name_of(end.status)) + " for a static observer at " + at);
    }
    for (const std::optional<ObserverKind> observer :
         {std::optional<ObserverKind>{}, std::optional(ObserverKind::static_), std::optional(ObserverKind::falling)})
        for (const RayEnd& end : trial.ends(plan, {RayInput{{0, 0, 0}, {1, 0, 0}}}, observer))
            trial.expect_status(end, Status::failed, "r = 0 " + (observer ? name_of(*observer) : std::string()));
}

// A ray whose areal distance is R = ρ + a²/4ρ has b = R sin(angle to the radius).
void throat(Trial& trial) {
    const double away = trial.in_float() ? 1e-4 : 1e-6, rho = 5, areal = rho + 0.25 / rho;
    for (const char* method : {"gauss8", "gauss12", "kahan-li8"}) {
        const auto plan =
            trial.plan(space_text("wormhole", "throat = 1.0",
                                  std::string("method = \"") + method + "\"\nstep = 0.1\nescape_radius = 10"));
        for (const double b : {0.0, 0.5, 1 - 1e-2, 1 - away, 1 + away, 1 + 1e-2, 2.0}) {
            std::vector<RayInput> rays;
            const double sine = b / areal, cosine = std::sqrt(1 - sine * sine);
            for (const OrbitPlane& plane : planes) {
                RayInput ray{};
                for (std::size_t k = 0; k < 3; ++k) {
                    ray.position[k] = rho * plane.outward[k];
                    ray.direction[k] = -cosine * plane.outward[k] + sine * plane.across[k];
                }
                rays.push_back(ray);
            }
            for (const RayEnd& end : trial.ends(plan, rays)) {
                const std::string ray = "b/a - 1 = " + number(b - 1) + ", " + method;
                trial.expect_status(end, Status::escaped, ray);
                const bool through = distance(end.q, {0, 0, 0}) < 0.5;
                trial.expect(through == (b < 1), std::string(through ? "through" : "back") + " at " + ray);
            }
        }
    }
}

}  // namespace kagero::stability
