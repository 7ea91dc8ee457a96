// Tests that the earliest event of a step ends the ray. Events are hits, edges of domains, capture, and the escape
// sphere. All ends are compared with positions that follow from the scene. Other tests place the start near a surface.
#include "tests/support/plan_fixture.h"

#include "scene/value.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kagero::test {
namespace {

const std::string view =
    "\n[camera]\nposition = [0, -10, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [8, 8]\n";

/// Returns a scene with a medium that bends rays slightly. `space_keys` contains further keys of the space.
std::string medium(const std::string& space_keys, const std::string& objects = "") {
    return "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - 1 - 0.1*exp(-x^2))\"\n" + space_keys +
           "\n[integrator]\nescape_radius = 50\n" + view + objects;
}
std::string wall(double x) {
    return "[[object]]\nshape = \"rectangle\"\norigin = [" + std::to_string(x) +
           ", -5, -5]\nedge_u = [0, 10, 0]\nedge_v = [0, 0, 10]\n";
}
const std::string room = "[[object]]\nname = \"room\"\nshape = \"room\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\n";
/// Returns a square with corners at (±half, ±half, z).
std::string floor(double half, double z) {
    return "[[object]]\nshape = \"rectangle\"\norigin = " + to_toml(Double3{-half, -half, z}) +
           "\nedge_u = " + to_toml(Double3{2 * half, 0, 0}) + "\nedge_v = " + to_toml(Double3{0, 2 * half, 0}) + "\n";
}
std::string ball(double radius) {
    return "[[object]]\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = " + std::to_string(radius) + "\n";
}

class EarliestEvent : public testing::TestWithParam<const char*> {
protected:
    std::vector<RayEnd> ends_of(const std::string& scene, const Overrides& settings,
                                const std::vector<RayInput>& rays) const {
        const auto plan = plan_of_text(scene, settings, with_strategy(GetParam()), false);
        std::vector<RayEnd> ends;
        trace(*plan, start_rays(*plan, rays), ends);
        return ends;
    }
    static std::vector<RayInput> rays_along_x() {
        std::vector<RayInput> rays;
        for (int i = 0; i < 40; ++i) rays.push_back({{0.02 * i, 0.01 * i, 0}, {1, 0.02, 0.001 * i}});
        return rays;
    }
};

const Overrides method_settings[] = {{"integrator.method=rkf78"},
                                     {"integrator.method=gauss8", "integrator.step=0.1"},
                                     {"integrator.method=rk4", "integrator.step=0.5"}};

TEST_P(EarliestEvent, EdgesHideSurfacesBeyondThem) {
    for (const auto& [edge, status] : {std::pair{"domain", Status::escaped}, std::pair{"capture", Status::captured}})
        for (const double x : {1.001, 1.02, 1.3})
            for (const Overrides& settings : method_settings) {
                SCOPED_TRACE(testing::Message() << edge << ", wall at " << x << ", " << settings[0]);
                for (const RayEnd& end :
                     ends_of(medium(std::string(edge) + " = \"1 - x\"", wall(x)), settings, rays_along_x())) {
                    ASSERT_EQ(end.status, status);
                    EXPECT_NEAR(end.q[0], 1, 1e-9);
                }
            }
}

// The region where `domain` or `capture` is negative is a layer that is thinner than a step, so that both ends of the
// step are outside the layer. The wall in the middle of the layer must not be hit.
TEST_P(EarliestEvent, LayersThinnerThanAStepHideSurfacesInThem) {
    for (const auto& [edge, status] : {std::pair{"domain", Status::escaped}, std::pair{"capture", Status::captured}})
        for (const Overrides& settings : method_settings) {
            SCOPED_TRACE(testing::Message() << edge << ", " << settings[0]);
            for (const RayEnd& end :
                 ends_of(medium(std::string(edge) + " = \"abs(x - 1) - 0.02\"", wall(1)), settings, rays_along_x())) {
                ASSERT_EQ(end.status, status);
                EXPECT_NEAR(end.q[0], 0.98, 1e-9);
            }
        }
}

TEST_P(EarliestEvent, EdgesDoNotHideSurfacesBeforeThem) {
    for (const double x : {0.8, 0.999})
        for (const Overrides& settings : method_settings)
            for (const RayEnd& end : ends_of(medium("domain = \"1 - x\"", wall(x)), settings, rays_along_x())) {
                ASSERT_EQ(end.status, Status::hit);
                EXPECT_NEAR(end.q[0], x, 1e-9);
            }
}

TEST_P(EarliestEvent, NearestOfSeveralEdgesEndsTheRay) {
    for (const Overrides& settings : method_settings) {
        SCOPED_TRACE(settings[0]);
        const auto rays = rays_along_x();
        for (const RayEnd& end : ends_of(medium("capture = \"1 - x\"\ndomain = \"1.05 - x\""), settings, rays)) {
            ASSERT_EQ(end.status, Status::captured);
            EXPECT_NEAR(end.q[0], 1, 1e-9);
        }
        for (const RayEnd& end : ends_of(medium("capture = \"1.05 - x\"\ndomain = \"1 - x\""), settings, rays)) {
            ASSERT_EQ(end.status, Status::escaped);
            EXPECT_NEAR(end.q[0], 1, 1e-9);
        }
        for (const RayEnd& end : ends_of(medium("domain = \"50.02 - sqrt(x^2 + y^2 + z^2)\""), settings, rays))
            EXPECT_NEAR(std::hypot(end.q[0], end.q[1], end.q[2]), 50, 1e-8);
    }
}

// Rays must not enter or start in regions where domain, capture or length_scale is NaN, or length_scale is ≤ 0.
TEST_P(EarliestEvent, RaysDoNotEnterRegionsWithInvalidBounds) {
    const std::vector<RayInput> start_beyond{{{2, 0, 0}, {-1, 0, 0}}};
    for (const char* edge : {"domain = \"sqrt(1 - x)\"", "capture = \"2 + sqrt(1 - x)\"",
                             "length_scale = \"sqrt(1 - x)\"", "length_scale = \"1 - x\""})
        for (const Overrides& settings : method_settings) {
            SCOPED_TRACE(testing::Message() << edge << ", " << settings[0]);
            Overrides limited = settings;
            limited.push_back("integrator.max_steps=400");  // the steps become ever shorter near x = 1
            for (const RayEnd& end : ends_of(medium(edge), limited, rays_along_x())) {
                EXPECT_TRUE(end.status == Status::failed || end.status == Status::step_limit);
                EXPECT_LE(end.q[0], 1);
            }
            for (const RayEnd& end : ends_of(medium(edge), settings, start_beyond))
                EXPECT_EQ(end.failure, Failure::invalid_bounds);
        }
    // Outside the domain, length_scale is not used.
    for (const Overrides& settings : method_settings)
        for (const RayEnd& end :
             ends_of(medium("domain = \"1 - x\"\nlength_scale = \"0.1 + sqrt(1 - x)\""), settings, start_beyond))
            EXPECT_EQ(end.status, Status::escaped);
    try {
        plan_of_text(medium("domain = \"sqrt(y)\""), {}, with_strategy(GetParam()));
        FAIL() << "The domain is NaN at the camera, but the scene was not refused.";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("camera.position = [0, -10, 0]: space.domain"), std::string::npos)
            << error.what();
    }
}

// H is NaN for z < 0, so that no step can end beyond the edge z = 0. Rays must end on the edge. The x coordinate of the
// end is compared with the integral of dx/dz = p_x/p_z by the midpoint rule.
TEST_P(EarliestEvent, EdgesAreReachedIfHIsUndefinedBeyondThem) {
    const std::vector<RayInput> rays{{{0, 0, 1}, {0.3, 0, -1}}, {{0, 0, 1}, {0.5, 0, -1}}, {{0, 0, 0.7}, {1, 0, -1}}};
    for (const char* edge : {"domain", "capture"})
        for (const char* method : {"srkn6", "gauss8", "rk4", "dp8", "gauss16"}) {
            const auto ends =
                ends_of(std::string(
                            "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - 1 - z^1.5)\"\n") +
                            edge + " = \"z\"\n[integrator]\nstep = 0.02\n" + view,
                        {std::string("integrator.method=") + method}, rays);
            for (std::size_t i = 0; i < rays.size(); ++i) {
                SCOPED_TRACE(std::string(edge) + " by " + method + ", ray " + std::to_string(i));
                ASSERT_EQ(ends[i].status, edge == std::string("domain") ? Status::escaped : Status::captured)
                    << describe(ends[i].failure);
                const double z = rays[i].position[2], n_squared = 1 + std::pow(z, 1.5), slope = rays[i].direction[0];
                const double px = slope * std::sqrt(n_squared / (1 + slope * slope));
                constexpr int intervals = 20000;
                double x = 0;
                for (int k = 0; k < intervals; ++k)
                    x += px * z / intervals / std::sqrt(1 + std::pow(z * (k + 0.5) / intervals, 1.5) - px * px);
                EXPECT_NEAR(ends[i].q[2], 0, 1e-8);
                EXPECT_NEAR(ends[i].q[0], x, 1e-5);
            }
        }
}

// A ball inside the horizon must not be hit. Rays with b < 3√3/2 r_g are captured, all others escape.
TEST_P(EarliestEvent, HorizonHidesSurfacesInsideIt) {
    std::vector<RayInput> rays;
    for (int i = 0; i < 40; ++i) rays.push_back({{0, -10, 0}, {0.0137 * (i - 19.5), 1, 0.004 * i}});
    const Overrides hole_methods[] = {{},
                                      {"integrator.method=orbit-srkn11", "integrator.step=0.05"},
                                      {"integrator.method=orbit-srkn11", "integrator.step=1"},
                                      {"integrator.symmetry=none"},
                                      {"integrator.method=gauss8"},
                                      {"integrator.method=dp54", "integrator.tolerance=1e-3"}};
    for (const double radius : {0.9, 0.99})
        for (const Overrides& settings : hole_methods) {
            SCOPED_TRACE(testing::Message()
                         << "ball of " << radius << ", " << (settings.empty() ? "default" : settings[0]));
            const std::string scene = "space = { hamiltonian = \"schwarzschild\", rg = 1 }\n" + view + ball(radius);
            const auto ends = ends_of(scene, settings, rays);
            for (std::size_t i = 0; i < ends.size(); ++i) {
                // At r = 10: dr/dλ = −√(1 − (1 − 1/r) b²/r²) and r dφ/dλ = b/r.
                const double slope = std::hypot(rays[i].direction[0], rays[i].direction[2]);
                const double b = 10 * slope / std::sqrt(1 + slope * slope * (1 - 1.0 / 10)),
                             critical = 1.5 * std::numbers::sqrt3;
                if (std::abs(b - critical) < 0.02) continue;
                EXPECT_EQ(ends[i].status, b < critical ? Status::captured : Status::escaped) << b;
            }
        }
}

// Rays of a falling observer have p_t < 0. They approach the horizon, but never cross it, and must be captured there.
// The floor intersects the horizon. All methods must capture the same number of rays, up to one.
TEST_P(EarliestEvent, HorizonCapturesRaysOfFallingObservers) {
    const std::string scene =
        "space = { hamiltonian = \"schwarzschild\", rg = 1 }\nintegrator.escape_radius = 30\n"
        "[camera]\nposition = [-6, 0, 1]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\nobserver = \"falling\"\n"
        "[film]\nsize = [36, 24]\nlayers = [\"status\"]\n" +
        floor(8, -0.3);
    std::vector<std::uint64_t> captured;
    for (const Overrides& settings :
         {Overrides{}, {"integrator.symmetry=none"}, {"integrator.method=rkf78"}, {"integrator.method=gauss8"}}) {
        const auto plan = plan_of_text(scene, settings, with_strategy(GetParam()));
        Film film(36, 24, plan->description().film.layers);
        const RunReport report = render(*plan, film);
        EXPECT_EQ(report.counters.ended[static_cast<int>(Status::failed)], 0u);
        captured.push_back(report.counters.ended[static_cast<int>(Status::captured)]);
    }
    for (const std::uint64_t count : captured) EXPECT_NEAR(double(count), double(captured.front()), 1);
    EXPECT_GT(captured.front(), 40u);
}

// The starts are 1e-3 to 1e-8 above the floor. Embree's floats do not resolve the smaller heights.
TEST_P(EarliestEvent, SurfacesCloseToTheStartAreHit) {
    const double floor_z = 0.7;
    for (const char* space : {"hamiltonian = \"flat\"", "hamiltonian = \"gradient\"\ng = 1e-3",
                              "hamiltonian = \"schwarzschild\"\nrg = 0.01\ncenter = [0, 0, 3]"}) {
        SCOPED_TRACE(space);
        const std::string scene = "[space]\n" + std::string(space) + view + floor(1, floor_z) + floor(1, -0.9);
        std::vector<RayInput> rays;
        for (const double height : {1e-3, 1e-5, 6e-6, 1e-6, 3e-7, 1e-8})
            rays.push_back({{0.1, 0.2, floor_z + height}, {0.3, 0.2, -1}});
        for (const RayEnd& end : ends_of(scene, {}, rays)) {
            EXPECT_EQ(end.status, Status::hit);
            EXPECT_EQ(end.surface, 0u);
        }
        // A ray that starts on a surface does not hit it at the start.
        const Double3 q{0.1, 0.2, floor_z};
        const auto ends = ends_of(scene, {}, {{q, {0.3, 0.2, -1}}, {q, {0.3, 0.2, 1}}});
        EXPECT_EQ(ends[0].status, Status::hit);
        EXPECT_EQ(ends[0].surface, 1u);
        EXPECT_EQ(ends[1].status, Status::escaped);
    }
}

// The starts are 1e-4 to 1e-14 below the ceiling of a closed room. Rays must hit the ceiling if they move up, else the
// floor, at λ > 0.
TEST_P(EarliestEvent, RaysFromNearAWallStayInAClosedRoom) {
    for (const std::string space : {"hamiltonian = \"flat\"", "hamiltonian = \"schwarzschild\"\nrg = 0.01",
                                    "hamiltonian = \"gradient\"\ng = 0.02", "hamiltonian = \"shimmer\""})
        for (const Overrides& settings :
             {Overrides{}, {"integrator.hit=chord"}, {"integrator.cull=none"}, {"integrator.escape_radius=1000"}}) {
            std::vector<RayInput> rays;
            for (double gap = 1e-14; gap < 1e-4; gap *= 3)
                for (const double dz : {-1.0, 1.0}) rays.push_back({{0.3, 0.5, 1 - gap}, {0.1, -0.2, dz}});
            const auto ends =
                ends_of("[space]\n" + space + "\n[integrator]\nescape_radius = 4\n" + view + room, settings, rays);
            for (std::size_t i = 0; i < ends.size(); ++i) {
                SCOPED_TRACE(testing::Message() << space << ", " << (settings.empty() ? "" : settings[0]) << ", "
                                                << 1 - rays[i].position[2]);
                ASSERT_EQ(ends[i].status, Status::hit);
                EXPECT_NEAR(ends[i].q[2], i % 2 ? 1 : -1, 1e-9);
                EXPECT_GT(ends[i].parameter, 0);
            }
        }
    const std::string globe = "[space]\nhamiltonian = \"flat\"\n[integrator]\nescape_radius = 4\n" + view + ball(1);
    std::vector<RayInput> rays;
    for (double gap = 1e-14; gap < 1e-4; gap *= 3) rays.push_back({{0, 1 - gap, 0}, {0.1, -1, 0.3}});
    for (const RayEnd& end : ends_of(globe, {}, rays)) {
        ASSERT_EQ(end.status, Status::hit);
        EXPECT_LT(end.q[1], 0);
    }
}

// A camera just below the ceiling looks up at it, or down through the room. All rays must hit the room.
TEST_P(EarliestEvent, RaysOfACameraNearTheCeilingStayInTheRoom) {
    for (const std::string space : {"hamiltonian = \"flat\"", "hamiltonian = \"schwarzschild\"\nrg = 0.001"})
        for (const std::string precision : {"double", "float"})
            for (double gap = 4e-6; gap < 1e-2; gap *= 1.7)
                for (const int sign : {1, -1}) {
                    SCOPED_TRACE(space + ", " + precision + ", " + to_toml(gap) + (sign > 0 ? " up" : " down"));
                    const Double3 eye{0.3, 0.5, 1 - gap};
                    const std::string camera = "[camera]\nposition = [0.3, 0.5, " + to_toml(eye[2]) +
                                               "]\nlook_at = [0.3, 0.4, " + to_toml(eye[2] + sign) + "]\nfov = 40\n";
                    Options options = with_strategy(GetParam());
                    options.precision = precision_named(precision);
                    const auto plan =
                        plan_of_text("[space]\n" + space +
                                         "\n[integrator]\nescape_radius = 4\n[film]\nsize = [8, 8]\n" + camera + room,
                                     {}, options);
                    ASSERT_NE(plan->job().camera, nullptr);
                    std::vector<RayEnd> ends(64);
                    Counters counters{};
                    const Tile tile{0, 0, 8, 8};
                    const Job job = plan->job();
                    plan->run.kernel->trace(&job, &tile, ends.data(), &counters);
                    for (const RayEnd& end : ends) {
                        ASSERT_EQ(end.status, Status::hit);
                        ASSERT_NEAR(std::max({std::abs(end.q[0]), std::abs(end.q[1]), std::abs(end.q[2])}), 1, 1e-6);
                        // The rays are less than 45° from the normal of the ceiling.
                        if (sign > 0) ASSERT_LE(std::hypot(end.q[0] - eye[0], end.q[1] - eye[1]), gap);
                        else ASSERT_LT(end.q[2], 0.5);
                    }
                }
}

// The ray starts on the floor, parallel to it, and bends away from it. Its path z = −2 − g λ²/4 never returns.
TEST_P(EarliestEvent, RaysDoNotHitTheFloorThatTheyLeave) {
    for (const char* g : {"1e-3", "1e-6"})
        for (const Overrides& settings : {Overrides{}, {"integrator.step=0.01"}, {"integrator.method=gauss8"}}) {
            const auto ends = ends_of(std::string("[space]\nhamiltonian = \"gradient\"\ng = ") + g +
                                          "\n[integrator]\nescape_radius = 50\n" + view + floor(20, -2),
                                      settings, {{{0, 0, -2}, {1, 0, 0}}});
            EXPECT_EQ(ends[0].status, Status::escaped) << g;
        }
}

// Rays that start on the escape sphere, tangentially to it, must escape at the start.
TEST_P(EarliestEvent, TangentsOfTheEscapeSphereEscapeAtTheStart) {
    for (const char* space : {"hamiltonian = \"gradient\"\ng = 1e-3", "hamiltonian = \"luneburg\"",
                              "hamiltonian = \"schwarzschild\"", "hamiltonian = \"flat\""}) {
        const auto ends = ends_of(std::string("[space]\n") + space + "\n[integrator]\nescape_radius = 50\n" + view, {},
                                  {{{0, 50, 0}, {1, 0, 0}}});
        EXPECT_EQ(ends[0].status, Status::escaped) << space;
        EXPECT_NEAR(ends[0].q[1], 50, 1e-8) << space;
    }
}

// Rays with b < a pass through the throat of radius a of Ellis's wormhole (Müller 2004). Ray i has b = 0.1 (i + ½) a.
TEST_P(EarliestEvent, RaysThroughTheThroatEscapeOnTheSecondSheet) {
    for (const double throat : {1.0, 1e-3, 1e-9})
        for (const Overrides& settings : {Overrides{"integrator.method=rk4", "integrator.step=3"},
                                          {"integrator.method=dp5", "integrator.step=2"},
                                          {"integrator.symmetry=none"},
                                          {"integrator.method=rkf78", "integrator.rescale=none"}}) {
            std::vector<RayInput> rays;
            const double distance = 6 * std::max(throat, 0.1), areal_r = distance + 0.25 * throat * throat / distance;
            for (int i = 0; i < 20; ++i) {
                const double sine = 0.1 * (i + 0.5) * throat / areal_r;
                rays.push_back(
                    {{-distance, 0, 0}, {std::sqrt(1 - sine * sine), sine * std::cos(i), sine * std::sin(i)}});
            }
            const auto ends = ends_of("space = { hamiltonian = \"wormhole\", throat = " + to_toml(throat) +
                                          " }\nintegrator.escape_radius = 20\n" + view,
                                      settings, rays);
            for (std::size_t i = 0; i < ends.size(); ++i) {
                SCOPED_TRACE(testing::Message() << "throat " << throat << ", " << settings[0] << ", ray " << i);
                ASSERT_EQ(ends[i].status, Status::escaped);
                EXPECT_EQ(std::hypot(ends[i].q[0], ends[i].q[1], ends[i].q[2]) < 0.5 * throat, i < 10);
            }
        }
}

INSTANTIATE_TEST_SUITE_P(Strategies, EarliestEvent, testing::Values("scalar", "packet"),
                         [](const auto& chosen) { return std::string(chosen.param); });

}  // namespace
}  // namespace kagero::test
