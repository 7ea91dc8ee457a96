// Tests methods that integrate rays in their orbit plane. The ends are compared with those of rays on the general path,
// and with closed forms. Such methods must be the default in spaces that support them.
#include "tests/support/plan_fixture.h"
#include "tests/support/schwarzschild_orbit.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace kagero::test {
namespace {

std::unique_ptr<Plan> hole_plan(Overrides overrides, const std::string& strategy = "packet") {
    overrides.insert(overrides.begin(), {"integrator.escape_radius=20", "space.center=[0.5, -3, 7]"});
    return plan_of_file(scene_file("hole.toml"), overrides, with_strategy(strategy), false);
}

std::vector<RayEnd> ends_of(const Plan& plan, const std::vector<RayInput>& rays, const std::string& observer = "") {
    std::vector<RayEnd> ends;
    trace(plan, start_rays(plan, rays, observer_of(observer)), ends);
    return ends;
}

/// Returns rays from three radii in 13 directions each, from radially outward to radially inward.
std::vector<RayInput> rays_in_all_directions() {
    std::vector<RayInput> all;
    for (const double r : {1.6, 3.0, 12.0})
        for (int k = 0; k <= 12; ++k) {
            const double angle = std::numbers::pi * k / 12;
            all.push_back(
                {{0.5 + 0.6 * r, -3 + 0.8 * r, 7}, {0.6 * std::cos(angle), 0.8 * std::cos(angle), std::sin(angle)}});
        }
    return all;
}

TEST(OrbitPlane, RaysMatchTheGeneralPath) {
    const auto general = hole_plan({"integrator.method=gauss16", "integrator.step=0.1"});
    const auto expected = ends_of(*general, rays_in_all_directions());
    for (const char* strategy : {"packet", "scalar"}) {
        const auto orbit = hole_plan({"integrator.method=orbit-srkn14", "integrator.step=0.05"}, strategy);
        const auto ends = ends_of(*orbit, rays_in_all_directions());
        std::size_t compared = 0;
        for (std::size_t i = 0; i < ends.size(); ++i) {
            SCOPED_TRACE(i);
            EXPECT_EQ(ends[i].status, expected[i].status);
            if (expected[i].status != Status::escaped) continue;
            ++compared;
            // Some thousand roundings of a state of size 20, amplified by the hole.
            for (int k = 0; k < 3; ++k) {
                EXPECT_NEAR(ends[i].q[k], expected[i].q[k], 1e-9);
                EXPECT_NEAR(ends[i].v[k], expected[i].v[k], 1e-10);
                EXPECT_NEAR(ends[i].p[k], expected[i].p[k], 1e-9);
            }
            EXPECT_NEAR(ends[i].parameter, expected[i].parameter, 1e-9);
            EXPECT_LT(ends[i].energy_error, 1e-10);
        }
        EXPECT_GE(compared, 10u);
    }
}

// Rays through the throat of a wormhole change to the second sheet, and rays in a fisheye are closed orbits.
TEST(OrbitPlane, RaysInOtherSphericalSpacesMatchTheGeneralPath) {
    const auto plan_of = [](const std::string& space, const Overrides& settings) {
        const std::string scene = "space = { hamiltonian = \"" + space +
                                  "\", center = [0.5, -3, 7] }\nintegrator.escape_radius = 3\n"
                                  "camera = { position = [1, -3, 7], look_at = [0, 0, 0] }\nfilm.size = [1, 2]\n";
        return plan_of_text(scene, settings, with_strategy("packet"), false);
    };
    std::vector<RayInput> rays;
    for (int k = 0; k < 24; ++k) {
        const double angle = 2 * std::numbers::pi * (k + 0.5) / 24;  // at least 7.5° from the radius
        rays.push_back(
            {{0.5 + 0.6 * 1.4, -3 + 0.8 * 1.4, 7}, {0.6 * std::cos(angle), 0.8 * std::cos(angle), std::sin(angle)}});
    }
    for (const std::string space : {"wormhole", "fisheye"}) {
        const auto expected =
            ends_of(*plan_of(space, {"integrator.method=gauss16", "integrator.step=0.05", "integrator.max_steps=1000"}),
                    rays);
        const auto ends = ends_of(*plan_of(space, {"integrator.method=orbit-srkn14", "integrator.step=0.02",
                                                   "integrator.max_steps=1000"}),
                                  rays);
        int escaped = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            SCOPED_TRACE(space + ", ray " + std::to_string(i));
            EXPECT_EQ(ends[i].status, expected[i].status);
            if (expected[i].status != Status::escaped) continue;
            ++escaped;
            const double size = std::hypot(expected[i].p[0], expected[i].p[1], expected[i].p[2]);
            for (int k = 0; k < 3; ++k) {
                EXPECT_NEAR(ends[i].q[k], expected[i].q[k], 1e-9);
                EXPECT_NEAR(ends[i].v[k], expected[i].v[k], 1e-9);
                EXPECT_NEAR(ends[i].p[k], expected[i].p[k], 1e-9 * size);
            }
            EXPECT_NEAR(ends[i].parameter, expected[i].parameter, 1e-8);
        }
        EXPECT_GE(escaped, 6) << space;
    }
}

// The rays are circles whose centres are far from the centre of the fisheye, so that the radius and the index of
// refraction vary by large factors. The rays must hit the ball in the same pixels as on the general path.
TEST(OrbitPlane, RaysOnEccentricCirclesInAFisheyeHitTheSameBall) {
    const std::string scene =
        "[space]\nhamiltonian = \"fisheye\"\nradius = 4\n[integrator]\nescape_radius = 60\nmax_steps = 1000\n"
        "[camera]\nposition = [2.8816, 7.4065, 0.7707]\nlook_at = [1.8655, 4.7246, -0.5825]\nup = [0, 0, 1]\nfov = 40\n"
        "[film]\nsize = [40, 30]\n[[object]]\nshape = \"sphere\"\ncenter = [1.8655, 4.7246, -0.5825]\nradius = "
        "0.36825\n";
    const auto statuses = [&](const char* method) {
        const auto plan = plan_of_text(scene, {std::string("integrator.method=") + method}, with_strategy("packet"));
        std::vector<RayStart> starts;
        for (std::uint32_t i = 0; i < 40 * 30; ++i) starts.push_back(pixel_ray_start(*plan, i % 40, i / 40));
        std::vector<RayEnd> ends;
        trace(*plan, starts, ends);
        std::vector<Status> found;
        for (const RayEnd& end : ends)
            found.push_back(end.status == Status::hit || end.status == Status::failed ? end.status : Status::escaped);
        return found;
    };
    const auto expected = statuses("gauss12");
    EXPECT_GT(std::count(expected.begin(), expected.end(), Status::hit), 100);
    for (const char* method : {"orbit-srkn6", "orbit-srkn11", "orbit-srkn14"})
        EXPECT_EQ(statuses(method), expected) << method;
}

TEST(OrbitPlane, SweptAngleMatchesTheEllipticIntegral) {
    const auto plan = hole_plan({"space.center=[0, 0, 0]", "integrator.method=orbit-srkn11"});
    const OrbitPlane plane{{1, 0, 0}, {0, 1, 0}};
    for (const double b : {2.7, 3.0, 5.0, 10.0}) {
        const auto ends = ends_of(*plan, {ray_inward(plane, b, 20, {0, 0, 0})});
        ASSERT_EQ(ends[0].status, Status::escaped);
        const double angle = plane.angle_of({ends[0].q[0], ends[0].q[1], ends[0].q[2]});
        EXPECT_NEAR(std::remainder(angle - Orbit(b).swept_around(20), 2 * std::numbers::pi), 0, 1e-7) << b;
    }
}

TEST(OrbitPlane, RaysFromNearAndInsideTheHorizonMatchTheGeneralPath) {
    const struct {
        const char* observer;
        double r;
    } observers[] = {{"static", 1 + 1e-6}, {"falling", 1.5}, {"falling", 1 + 1e-3}, {"falling", 0.7}};
    for (const auto& [observer, r] : observers) {
        std::vector<RayInput> rays;
        for (int k = 0; k <= 24; ++k) {
            // From a static observer at r = (1 + 1e-6) r_g, only rays within 0.0026 of the outward direction escape.
            const double angle = (observer == std::string("static") ? 0.004 : std::numbers::pi) * (k + 0.5) / 25;
            rays.push_back({{0.5 + r, -3, 7}, {std::cos(angle), std::sin(angle), 0}});
        }
        // At r = (1 + 1e-6) r_g the general path is less accurate: H is a small difference of large terms, with a
        // relative error of 1e-5.
        const double tolerance = r < 1 + 1e-5 && r > 1 ? 5e-4 : 1e-6;
        const auto general = ends_of(*hole_plan({"integrator.method=gauss12", "integrator.step=0.02"}), rays, observer);
        const auto orbit = ends_of(*hole_plan({"integrator.method=orbit-srkn11"}), rays, observer);
        std::size_t compared = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            SCOPED_TRACE(std::string(observer) + " at " + std::to_string(r) + ", ray " + std::to_string(i));
            EXPECT_EQ(orbit[i].status, general[i].status);
            if (orbit[i].status != Status::escaped || general[i].status != Status::escaped) continue;
            for (int k = 0; k < 3; ++k) EXPECT_NEAR(orbit[i].v[k], general[i].v[k], tolerance);
            ++compared;
        }
        if (r > 1) {
            EXPECT_GE(compared, 3u) << observer << " at " << r;
        }
    }
}

// Rays of a falling observer have p_t < 0, and their radial speed varies between 0 and |p_t|. Their energy error must
// be less than three times that of the rays of a static observer.
TEST(OrbitPlane, EnergyErrorsOfFallingObserversAreSmall) {
    std::vector<RayInput> rays;
    for (int i = 0; i < 500; ++i) rays.push_back({{0.5 - 20, -3, 7}, {1, 0.15 + 4e-4 * i, 0}});
    const auto greatest_energy_error = [&](const char* observer, const char* precision) {
        Options options = with_strategy("packet");
        options.precision = precision_named(precision);
        options.energy_error = true;
        options.observer = observer_of(observer);
        const auto plan = plan_of_file(scene_file("hole.toml"), {"space.center=[0.5, -3, 7]"}, options, false);
        double greatest = 0;
        for (const RayEnd& end : ends_of(*plan, rays, observer)) {
            EXPECT_EQ(end.status, Status::escaped);
            greatest = std::max(greatest, end.energy_error);
        }
        return greatest;
    };
    for (const char* precision : {"double", "float"})
        EXPECT_LT(greatest_energy_error("falling", precision), 3 * greatest_energy_error("static", precision))
            << precision;
}

// The derivative of the radius with respect to the angle is very large on a radial ray: in float, its square would
// overflow.
TEST(OrbitPlane, RadialRaysHaveADirectionAtAnyEscapeRadius) {
    for (const char* radius : {"1e3", "1e5", "1e9"}) {
        Options options = with_strategy("packet");
        options.precision = Precision::float32;
        const auto plan = plan_of_file(scene_file("hole.toml"),
                                       {"space.center=[0.5, -3, 7]", "integrator.method=orbit-srkn11",
                                        std::string("integrator.escape_radius=") + radius},
                                       options, false);
        const RayEnd end = ends_of(*plan, {{{0.5 - 12, -3 + 16, 7}, {-0.6, 0.8, 0}}})[0];
        ASSERT_EQ(end.status, Status::escaped) << radius;
        const double expected[] = {-0.6, 0.8, 0};
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(end.v[k], expected[k], 1e-6) << radius;
    }
}

// The rays start at a distance of 1e5 r_g, where the rounding of the direction to float would change the impact
// parameter by 0.01 r_g. The start of an orbit is therefore computed in double.
TEST(OrbitPlane, DistantStartsInFloatMatchDouble) {
    std::vector<RayInput> rays;
    for (int k = 0; k < 16; ++k) {
        const double angle = (4 + 0.25 * k) / 1e5;
        rays.push_back(
            {{0.5 + 0.6e5, -3 + 0.8e5, 7}, {-0.6 * std::cos(angle), -0.8 * std::cos(angle), std::sin(angle)}});
    }
    const auto ends_in = [&](const std::string& precision) {
        Options options = with_strategy("packet");
        options.precision = precision_named(precision);
        const auto plan = plan_of_file(scene_file("hole.toml"),
                                       {"integrator.escape_radius=2e5", "space.center=[0.5, -3, 7]",
                                        "integrator.method=orbit-srkn11", "integrator.step=0.5"},
                                       options, false);
        return ends_of(*plan, rays);
    };
    const auto expected = ends_in("double"), ends = ends_in("float");
    for (std::size_t i = 0; i < rays.size(); ++i) {
        SCOPED_TRACE(i);
        ASSERT_EQ(expected[i].status, Status::escaped);
        ASSERT_EQ(ends[i].status, Status::escaped);
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(ends[i].v[k], expected[i].v[k], 3e-6);
    }
}

TEST(OrbitPlane, HitsMatchTheGeneralPath) {
    const auto render_room = [](const Overrides& overrides) {
        auto settings = overrides;
        settings.push_back("film.size=[96, 96]");
        settings.push_back("film.layers=[\"status\", \"object\", \"depth\"]");
        const auto plan = plan_of_file(scene_file("room.toml"), settings, with_strategy("packet"));
        Film film(96, 96, plan->description().film.layers);
        render(*plan, film, {});
        return film;
    };
    const Film general = render_room({"integrator.method=gauss12", "integrator.step=0.2"});
    // Status, object and depth must agree, depth within `tolerance`, in all but three pixels. In the corner of two
    // walls, the error of the dense output determines which wall is hit.
    const auto expect_same = [&](const Film& orbit, float tolerance) {
        int different = 0;
        for (std::size_t i = 0; i < 96 * 96; ++i) {
            const bool same_surface = orbit.plane("status")[i] == general.plane("status")[i] &&
                                      orbit.plane("object")[i] == general.plane("object")[i];
            const float error = std::abs(orbit.plane("depth")[i] - general.plane("depth")[i]);
            different += !same_surface || error > tolerance;
            EXPECT_LT(error, 2e-3f) << "pixel " << i;
        }
        EXPECT_LE(different, 3);
    };
    expect_same(render_room({}), 1e-5f);
    // Long steps are divided until their dense output is accurate enough.
    for (const char* step : {"integrator.step=1", "integrator.step=1.5", "integrator.step=1000"})
        expect_same(render_room({"integrator.method=orbit-srkn11", step}), 1e-3f);
}

TEST(OrbitPlane, SettingsForTheGeneralPathSelectAnotherMethod) {
    EXPECT_STREQ(hole_plan({"integrator.step=0.3"})->method().name, "dp8");
    EXPECT_STREQ(hole_plan({"integrator.rescale=none", "integrator.step=0.01"})->method().name, "dp8");
    // With these settings the default is a method with step control.
    for (const char* setting : {"integrator.tolerance=1e-4", "integrator.rescale=none", "integrator.symmetry=none"})
        EXPECT_STREQ(hole_plan({setting})->method().name, "dp85") << setting;
    EXPECT_THROW(hole_plan({"integrator.symmetry=none", "integrator.method=orbit-srkn6"}), InputError);
    EXPECT_THROW(plan_of_file(scene_file("kerr.toml"), {"integrator.method=orbit-srkn6"}), InputError);
}

}  // namespace
}  // namespace kagero::test
