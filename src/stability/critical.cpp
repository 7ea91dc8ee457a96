#include "stability/critical.h"

#include "stability/orbits.h"

#include <cmath>
#include <numbers>

namespace kagero::stability {

std::string hole_scene_text(const std::string& method, double step, const std::string& integrator) {
    return space_text("schwarzschild", "rg = 1.0",
                      "method = \"" + method + "\"\nstep = " + number(step) +
                          "\nescape_radius = 20\nmax_steps = 100000\n" + integrator);
}

namespace {

/// Returns the angle that each ray sweeps in its orbit plane, in radians, summed along its path. Ray i stays in the
/// plane planes[i]; its start lies in the direction `outward` of this plane, at the angle 0.
std::vector<double> swept_angles(const std::vector<PathPoint>& points, std::size_t rays) {
    std::vector<double> swept_angle(rays, 0), last(rays, 0);
    for (const PathPoint& point : points) {
        const OrbitPlane& plane = planes[point.ray];
        const Double3 q{point.q[0], point.q[1], point.q[2]};
        const double angle = std::atan2(dot(q, plane.across), dot(q, plane.outward));
        swept_angle[point.ray] += std::remainder(angle - last[point.ray], 2 * std::numbers::pi);
        last[point.ray] = angle;
    }
    return swept_angle;
}

/// Traces inward rays with impact parameter b in all planes. Each must be captured, or escape, after at least
/// `min_revolutions`. A straight ray sweeps the angle π until it escapes, and π/2 until it reaches the hole. This angle
/// is subtracted from the swept angle before the revolutions are counted.
void expect_revolutions(CaseRun& run, double b, double min_revolutions, const char* method) {
    std::vector<RayInput> rays;
    for (const OrbitPlane& plane : planes) rays.push_back(ray_inward(plane, b, 10));
    const auto plan = run.plan(hole_scene_text(method, std::string(method).starts_with("gauss") ? 0.04 : 0.02));
    run.ends(plan, rays);  // Checks the ray ends.
    std::vector<RayEnd> ends;
    const auto swept_angle = swept_angles(trace_paths(plan, start_rays(plan, rays), ends), rays.size());
    for (std::size_t i = 0; i < ends.size(); ++i) {
        const std::string ray =
            "plane " + std::to_string(i) + ", b/b_c - 1 = " + number(b / critical_impact - 1) + ", " + method;
        run.expect(ends[i].status == Status::captured || ends[i].status == Status::escaped,
                   std::string(name_of(ends[i].status)) + " at " + ray);
        const double straight_angle = ends[i].status == Status::captured ? 0.5 : 1,  // in units of π
            revolutions = 0.5 * (swept_angle[i] / std::numbers::pi - straight_angle);
        run.expect(revolutions >= min_revolutions,
                   std::to_string(revolutions) + " revolutions, " + name_of(ends[i].status) + ", at " + ray);
        if (i == 0 && !run.is_scalar())
            run.note(std::to_string(revolutions).substr(0, 4) + " revolutions, " + name_of(ends[i].status) + ", " +
                     method);
    }
}

}  // namespace

// Near b_c the deflection is −ln(b/b_c − 1) − 0.40 (Luminet 1979). At b/b_c − 1 = `deviation`, rays make
// `min_revolutions` + 0.1 revolutions.
void photon_sphere(CaseRun& run) {
    const double min_revolutions = run.in_float() ? 2 : 4,
                 deviation = std::exp(-2 * std::numbers::pi * (min_revolutions + 0.1) - 0.4);
    for (const double b : {critical_impact, critical_impact * (1 + deviation)})
        for (const char* method : {"gauss8", "gauss12", "gauss16", "kahan-li8", "s10", "ks-s10"}) {
            // In float, only the Gauss methods use compensated summation.
            if (run.in_float() && !std::string(method).starts_with("gauss")) continue;
            expect_revolutions(run, b, min_revolutions, method);
        }
}

void near_critical(CaseRun& run) {
    for (const char* method : {"gauss8", "gauss12", "ks-s10", "kahan-li8", "suzuki4-nine"}) {
        const bool is_fourth_order = std::string(method) == "suzuki4-nine";
        const auto plan = run.plan(hole_scene_text(method, is_fourth_order ? 0.02 : 0.1));
        for (const double deviation : {1e-6, 1e-4, 1e-2}) {
            if (run.in_float() && deviation < 1e-4) continue;
            for (const double sign : {-1.0, 1.0}) {
                std::vector<RayInput> rays;
                for (const OrbitPlane& plane : planes)
                    rays.push_back(ray_inward(plane, critical_impact * (1 + sign * deviation), 10));
                for (const RayEnd& end : run.ends(plan, rays))
                    run.expect_status(end, sign < 0 ? Status::captured : Status::escaped,
                                      "b/b_c - 1 = " + number(sign * deviation) + ", " + method);
            }
        }
    }
}

// Escape cone of a static observer at r < 3/2 r_g: rays escape within the angle θ of the outward direction, where
// sin θ = b_c √(1 − 1/r)/r (Synge 1966).
void near_horizon(CaseRun& run) {
    for (const double height : {1e-2, 1e-4, 1e-6}) {
        const double r = 1 + height, escape_cone = std::asin(critical_impact * std::sqrt(1 - 1 / r) / r);
        const std::string at = "r - rg = " + number(height);
        const std::string refusal =
            run.refusal(hole_scene_text("gauss8", 0.1) + "[camera]\nposition = [" + number(r) +
                        ", 0, 0]\nlook_at = [2, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [4, 4]\n");
        run.expect(refusal.empty() || run.in_float(), refusal);
        if (!refusal.empty() && run.in_float() && !run.is_scalar()) run.note("the camera is refused at " + at);
        const auto plan = run.plan(hole_scene_text("gauss8", 0.1));
        for (const double fraction : {0.5, 0.9, 1.1, 2.0}) {
            std::vector<RayInput> rays;
            for (int i = 0; i < 8; ++i) {
                const double azimuth = i * std::numbers::pi / 4, angle = fraction * escape_cone;
                rays.push_back(
                    {{r, 0, 0},
                     {std::cos(angle), std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth)}});
            }
            for (const RayEnd& end : run.ends(plan, rays, ObserverKind::static_)) {
                if (run.in_float() && end.status == Status::failed) continue;
                run.expect_status(end, fraction < 1 ? Status::escaped : Status::captured,
                                  number(fraction) + " of the angle of the escape cone, " + at);
            }
        }
    }
}

void inside(CaseRun& run) {
    const auto plan = run.plan(hole_scene_text("gauss8", 0.1));
    std::vector<Double3> directions;  // from the centre of a cube to its 26 corners, edges and faces
    for (int i = 0; i < 27; ++i)
        if (i != 13) directions.push_back({i % 3 - 1.0, i / 3 % 3 - 1.0, i / 9 - 1.0});
    for (const double r : {1.0, 0.999999, 0.75, 0.5, 0.1}) {
        std::vector<RayInput> rays;
        for (const Double3& d : directions) rays.push_back({{r, 0, 0}, d});
        const std::string at = "r = " + number(r);
        const auto ends = run.ends(plan, rays, ObserverKind::falling);
        for (std::size_t i = 0; i < ends.size(); ++i)
            run.expect(ends[i].status == Status::escaped || ends[i].status == Status::captured,
                       std::string(name_of(ends[i].status)) + " (" + describe(ends[i].failure) +
                           ") for a falling observer at " + at);
        // For a falling observer inside the horizon, the outward direction shows the outer sky.
        run.expect_status(run.ends(plan, {RayInput{{r, 0, 0}, {1, 0, 0}}}, ObserverKind::falling)[0], Status::escaped,
                          "outward, " + at);
        for (const RayEnd& end : run.ends(plan, rays, ObserverKind::static_))
            run.expect(end.status == Status::failed,
                       std::string(name_of(end.status)) + " for a static observer at " + at);
    }
    for (const std::optional<ObserverKind> observer :
         {std::optional<ObserverKind>{}, std::optional(ObserverKind::static_), std::optional(ObserverKind::falling)})
        for (const RayEnd& end : run.ends(plan, {RayInput{{0, 0, 0}, {1, 0, 0}}}, observer))
            run.expect_status(end, Status::failed, "r = 0 " + (observer ? name_of(*observer) : std::string()));
}

// The radius of the throat is a = 1. In isotropic coordinates with radius ρ, the areal radius is R = ρ + a²/4ρ. A ray
// has the impact parameter b = R sin(angle to the radial direction), and passes through the throat if b < a. The throat
// lies at ρ = a/2; points of the second sheet have smaller ρ.
void throat(CaseRun& run) {
    const double deviation = run.in_float() ? 1e-4 : 1e-6, rho = 5, areal_radius = rho + 0.25 / rho;
    for (const char* method : {"gauss8", "gauss12", "kahan-li8"}) {
        const auto plan =
            run.plan(space_text("wormhole", "throat = 1.0",
                                std::string("method = \"") + method + "\"\nstep = 0.1\nescape_radius = 10"));
        for (const double b : {0.0, 0.5, 1 - 1e-2, 1 - deviation, 1 + deviation, 1 + 1e-2, 2.0}) {
            std::vector<RayInput> rays;
            const double sine = b / areal_radius, cosine = std::sqrt(1 - sine * sine);
            for (const OrbitPlane& plane : planes) {
                RayInput ray{};
                for (std::size_t k = 0; k < 3; ++k) {
                    ray.position[k] = rho * plane.outward[k];
                    ray.direction[k] = -cosine * plane.outward[k] + sine * plane.across[k];
                }
                rays.push_back(ray);
            }
            for (const RayEnd& end : run.ends(plan, rays)) {
                const std::string ray = "b/a - 1 = " + number(b - 1) + ", " + method;
                run.expect_status(end, Status::escaped, ray);
                const bool is_transmitted = distance(end.q, {0, 0, 0}) < 0.5;
                run.expect(is_transmitted == (b < 1),
                           std::string(is_transmitted ? "passes through the throat" : "turns back") + " at " + ray);
            }
        }
    }
}

}  // namespace kagero::stability
