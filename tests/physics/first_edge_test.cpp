// Of all that may end a ray in one step, what it meets first does: surfaces, the edges of media and of capture, the
// escape sphere; and surfaces close to where it starts.
#include "tests/support/plan_fixture.h"

#include "scene/value.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kagero::test {
namespace {

const std::string view =
    "\n[camera]\nposition = [0, -10, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [8, 8]\n";

/// A medium whose rays bend a little, with some edges.
std::string medium(const std::string& edges, const std::string& objects = "") {
    return "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - 1 - 0.1*exp(-x^2))\"\n" + edges +
           "\n[integrator]\nescape_radius = 50\n" + view + objects;
}
std::string wall(double x) {
    return "[[object]]\nshape = \"rectangle\"\norigin = [" + std::to_string(x) +
           ", -5, -5]\nedge_u = [0, 10, 0]\nedge_v = [0, 0, 10]\n";
}
std::string ball(double radius) {
    return "[[object]]\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = " + std::to_string(radius) + "\n";
}

class FirstEdge : public testing::TestWithParam<const char*> {
protected:
    std::vector<RayEnd> ends_of(const std::string& scene, const Overrides& how,
                                const std::vector<RayInput>& rays) const {
        const auto plan = plan_of_text(scene, how, with_strategy(GetParam()), false);
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

const Overrides methods[] = {{"integrator.method=rkf78"},
                             {"integrator.method=gauss8", "integrator.step=0.1"},
                             {"integrator.method=rk4", "integrator.step=0.5"}};

TEST_P(FirstEdge, OfAMediumHidesWhatLiesBeyond) {
    for (const auto& [edge, status] : {std::pair{"domain", Status::escaped}, std::pair{"capture", Status::captured}})
        for (const double beyond : {1.001, 1.02, 1.3})
            for (const Overrides& how : methods) {
                SCOPED_TRACE(testing::Message() << edge << ", wall at " << beyond << ", " << how[0]);
                for (const RayEnd& end :
                     ends_of(medium(std::string(edge) + " = \"1 - x\"", wall(beyond)), how, rays_along_x())) {
                    ASSERT_EQ(end.status, status);
                    EXPECT_NEAR(end.q[0], 1, 1e-9);
                }
            }
}

// The whole step leads through the edge and out again; what is met in between lies beyond the edge all the same.
TEST_P(FirstEdge, OfALayerThinnerThanAStepHidesWhatLiesInIt) {
    for (const auto& [edge, status] : {std::pair{"domain", Status::escaped}, std::pair{"capture", Status::captured}})
        for (const Overrides& how : methods) {
            SCOPED_TRACE(testing::Message() << edge << ", " << how[0]);
            for (const RayEnd& end :
                 ends_of(medium(std::string(edge) + " = \"abs(x - 1) - 0.02\"", wall(1)), how, rays_along_x())) {
                ASSERT_EQ(end.status, status);
                EXPECT_NEAR(end.q[0], 0.98, 1e-9);
            }
        }
}

TEST_P(FirstEdge, DoesNotHideWhatLiesBefore) {
    for (const double before : {0.8, 0.999})
        for (const Overrides& how : methods)
            for (const RayEnd& end : ends_of(medium("domain = \"1 - x\"", wall(before)), how, rays_along_x())) {
                ASSERT_EQ(end.status, Status::hit);
                EXPECT_NEAR(end.q[0], before, 1e-9);
            }
}

TEST_P(FirstEdge, OfSeveralEndsTheRay) {
    for (const Overrides& how : methods) {
        SCOPED_TRACE(how[0]);
        for (const RayEnd& end : ends_of(medium("capture = \"1 - x\"\ndomain = \"1.05 - x\""), how, rays_along_x())) {
            ASSERT_EQ(end.status, Status::captured);
            EXPECT_NEAR(end.q[0], 1, 1e-9);
        }
        for (const RayEnd& end : ends_of(medium("capture = \"1.05 - x\"\ndomain = \"1 - x\""), how, rays_along_x())) {
            ASSERT_EQ(end.status, Status::escaped);
            EXPECT_NEAR(end.q[0], 1, 1e-9);
        }
        for (const RayEnd& end : ends_of(medium("domain = \"50.02 - sqrt(x^2 + y^2 + z^2)\""), how, rays_along_x()))
            EXPECT_NEAR(std::hypot(end.q[0], end.q[1], end.q[2]), 50, 1e-8);
    }
}

// What is no number bounds nothing, and a step of no length leads nowhere: rays do not come there, nor start there.
TEST_P(FirstEdge, IsANumberOrTheRayFails) {
    const std::vector<RayInput> beyond{{{2, 0, 0}, {-1, 0, 0}}};
    for (const char* edge : {"domain = \"sqrt(1 - x)\"", "capture = \"2 + sqrt(1 - x)\"",
                             "length_scale = \"sqrt(1 - x)\"", "length_scale = \"1 - x\""})
        for (const Overrides& how : methods) {
            SCOPED_TRACE(testing::Message() << edge << ", " << how[0]);
            Overrides few = how;
            few.push_back("integrator.max_steps=400");  // shorter and shorter ones
            for (const RayEnd& end : ends_of(medium(edge), few, rays_along_x())) {
                EXPECT_TRUE(end.status == Status::failed || end.status == Status::step_limit);
                EXPECT_LE(end.q[0], 1);
            }
            for (const RayEnd& end : ends_of(medium(edge), how, beyond)) EXPECT_EQ(end.failure, Failure::no_bounds);
        }
    // Beyond an edge it does not matter how long steps may be.
    for (const Overrides& how : methods)
        for (const RayEnd& end :
             ends_of(medium("domain = \"1 - x\"\nlength_scale = \"0.1 + sqrt(1 - x)\""), how, beyond))
            EXPECT_EQ(end.status, Status::escaped);
    const std::string at_the_camera = medium("domain = \"sqrt(y)\"");
    try {
        plan_of_text(at_the_camera, {}, with_strategy(GetParam()));
        FAIL() << "drawn";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("camera.position = [0, -10, 0]: space.domain"), std::string::npos)
            << error.what();
    }
}

// Beyond z = 0 H is no number, and no step ends there: rays end on it all the same, where dx/dz = p_x/p_z leads.
TEST_P(FirstEdge, IsReachedThoughHEndsThere) {
    const std::vector<RayInput> rays{{{0, 0, 1}, {0.3, 0, -1}}, {{0, 0, 1}, {0.5, 0, -1}}, {{0, 0, 0.7}, {1, 0, -1}}};
    for (const char* what : {"domain", "capture"})
        for (const char* method : {"srkn6", "gauss8", "rk4", "dp8", "gauss16"}) {
            const auto ends =
                ends_of(std::string(
                            "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - 1 - z^1.5)\"\n") +
                            what + " = \"z\"\n[integrator]\nstep = 0.02\n" + view,
                        {std::string("integrator.method=") + method}, rays);
            for (std::size_t i = 0; i < rays.size(); ++i) {
                SCOPED_TRACE(std::string(what) + " by " + method + ", ray " + std::to_string(i));
                ASSERT_EQ(ends[i].status, what == std::string("domain") ? Status::escaped : Status::captured)
                    << describe(ends[i].failure);
                const double z = rays[i].position[2], square = 1 + std::pow(z, 1.5), slope = rays[i].direction[0];
                const double px = slope * std::sqrt(square / (1 + slope * slope));
                constexpr int pieces = 20000;
                double x = 0;
                for (int k = 0; k < pieces; ++k)
                    x += px * z / pieces / std::sqrt(1 + std::pow(z * (k + 0.5) / pieces, 1.5) - px * px);
                EXPECT_NEAR(ends[i].q[2], 0, 1e-8);
                EXPECT_NEAR(ends[i].q[0], x, 1e-5);
            }
        }
}

// Nothing within a horizon is seen from without: rays of b < 3√3/2 r_g are captured, and no others.
TEST_P(FirstEdge, OfAHoleIsTheHorizon) {
    std::vector<RayInput> rays;
    for (int i = 0; i < 40; ++i) rays.push_back({{0, -10, 0}, {0.0137 * (i - 19.5), 1, 0.004 * i}});
    const Overrides ways[] = {{},
                              {"integrator.method=orbit-srkn11", "integrator.step=0.05"},
                              {"integrator.method=orbit-srkn11", "integrator.step=1"},
                              {"integrator.symmetry=none"},
                              {"integrator.method=gauss8"},
                              {"integrator.method=dp54", "integrator.tolerance=1e-3"}};
    for (const double radius : {0.9, 0.99})
        for (const Overrides& how : ways) {
            SCOPED_TRACE(testing::Message() << "ball of " << radius << ", " << (how.empty() ? "default" : how[0]));
            const auto ends =
                ends_of("space = { hamiltonian = \"schwarzschild\", rg = 1 }\n" + view + ball(radius), how, rays);
            for (std::size_t i = 0; i < ends.size(); ++i) {
                // dr/dλ = −√(1 − (1 − 1/r) b²/r²), r dφ/dλ = b/r.
                const double slope = std::hypot(rays[i].direction[0], rays[i].direction[2]);
                const double b = 10 * slope / std::sqrt(1 + slope * slope * (1 - 1.0 / 10)),
                             critical = 1.5 * std::numbers::sqrt3;
                if (std::abs(b - critical) < 0.02) continue;
                EXPECT_EQ(ends[i].status, b < critical ? Status::captured : Status::escaped) << b;
            }
        }
}

// Light with p_t < 0, as a falling observer sees it, comes close to the horizon and never through: whatever reaches
// from without to within.
TEST_P(FirstEdge, IsTheHorizonForLightThatNeverReachesIt) {
    const std::string scene =
        "space = { hamiltonian = \"schwarzschild\", rg = 1 }\nintegrator.escape_radius = 30\n[camera]\nposition = [-6, "
        "0, 1]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n"
        "observer = \"falling\"\n[film]\nsize = [36, 24]\nlayers = [\"status\"]\n"
        "[[object]]\nshape = \"rectangle\"\norigin = [-8, -8, -0.3]\nedge_u = [16, 0, 0]\nedge_v = [0, 16, 0]\n";
    std::vector<std::uint64_t> captured;
    for (const Overrides& how :
         {Overrides{}, {"integrator.symmetry=none"}, {"integrator.method=rkf78"}, {"integrator.method=gauss8"}}) {
        const auto plan = plan_of_text(scene, how, with_strategy(GetParam()));
        Film film(36, 24, plan->description().film.layers);
        const RunReport report = render(*plan, film);
        EXPECT_EQ(report.counters.ended[static_cast<int>(Status::failed)], 0u);
        captured.push_back(report.counters.ended[static_cast<int>(Status::captured)]);
    }
    for (const std::uint64_t count : captured) EXPECT_NEAR(double(count), double(captured.front()), 1);
    EXPECT_GT(captured.front(), 40u);
}

// Closer than Embree's floats tell places apart; off the scene's middle, where they are coarse, too.
TEST_P(FirstEdge, MayBeCloseToTheStart) {
    const auto floor = [](double z) {
        return "[[object]]\nshape = \"rectangle\"\norigin = [-1, -1, " + written(z) +
               "]\nedge_u = [2, 0, 0]\nedge_v = [0, 2, 0]\n";
    };
    const double level = 0.7;
    for (const char* space : {"hamiltonian = \"flat\"", "hamiltonian = \"gradient\"\ng = 1e-3",
                              "hamiltonian = \"schwarzschild\"\nrg = 0.01\ncenter = [0, 0, 3]"}) {
        SCOPED_TRACE(space);
        const std::string scene = "[space]\n" + std::string(space) + view + floor(level) + floor(-0.9);
        std::vector<RayInput> rays;
        for (const double height : {1e-3, 1e-5, 6e-6, 1e-6, 3e-7, 1e-8})
            rays.push_back({{0.1, 0.2, level + height}, {0.3, 0.2, -1}});
        for (const RayEnd& end : ends_of(scene, {}, rays)) {
            EXPECT_EQ(end.status, Status::hit);
            EXPECT_EQ(end.surface, 0u);
        }
        // … but what a ray starts on it leaves behind.
        const auto ends = ends_of(scene, {}, {{{0.1, 0.2, level}, {0.3, 0.2, -1}}, {{0.1, 0.2, level}, {0.3, 0.2, 1}}});
        EXPECT_EQ(ends[0].status, Status::hit);
        EXPECT_EQ(ends[0].surface, 1u);
        EXPECT_EQ(ends[1].status, Status::escaped);
    }
}

// Closer than Embree's floats can tell; in a closed room, none gets out, and none ends behind its start.
TEST_P(FirstEdge, MayBeCloserThanFloatsTell) {
    const std::string room = "[[object]]\nname = \"room\"\nshape = \"room\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\n";
    for (const std::string space : {"hamiltonian = \"flat\"", "hamiltonian = \"schwarzschild\"\nrg = 0.01",
                                    "hamiltonian = \"gradient\"\ng = 0.02", "hamiltonian = \"shimmer\""})
        for (const Overrides& how :
             {Overrides{}, {"integrator.hit=chord"}, {"integrator.cull=none"}, {"integrator.escape_radius=1000"}}) {
            std::vector<RayInput> rays;
            for (double gap = 1e-14; gap < 1e-4; gap *= 3)
                for (const double down : {-1.0, 1.0}) rays.push_back({{0.3, 0.5, 1 - gap}, {0.1, -0.2, down}});
            const auto ends =
                ends_of("[space]\n" + space + "\n[integrator]\nescape_radius = 4\n" + view + room, how, rays);
            for (std::size_t i = 0; i < ends.size(); ++i) {
                SCOPED_TRACE(testing::Message()
                             << space << ", " << (how.empty() ? "" : how[0]) << ", " << 1 - rays[i].position[2]);
                ASSERT_EQ(ends[i].status, Status::hit);
                EXPECT_NEAR(ends[i].q[2], i % 2 ? 1 : -1, 1e-9);
                EXPECT_GT(ends[i].parameter, 0);
            }
        }
    const std::string shell = "[space]\nhamiltonian = \"flat\"\n[integrator]\nescape_radius = 4\n" + view + ball(1);
    std::vector<RayInput> rays;
    for (double gap = 1e-14; gap < 1e-4; gap *= 3) rays.push_back({{0, 1 - gap, 0}, {0.1, -1, 0.3}});
    for (const RayEnd& end : ends_of(shell, {}, rays)) {
        ASSERT_EQ(end.status, Status::hit);
        EXPECT_LT(end.q[1], 0);
    }
}

// A camera just under the ceiling looks up at it, and away from it through the room: at whatever height a camera may
// be, no ray gets out.
TEST_P(FirstEdge, MayBeCloseToTheCamera) {
    const std::string room = "[[object]]\nname = \"room\"\nshape = \"room\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\n";
    for (const std::string space : {"hamiltonian = \"flat\"", "hamiltonian = \"schwarzschild\"\nrg = 0.001"})
        for (const std::string precision : {"double", "float"})
            for (double gap = 4e-6; gap < 1e-2; gap *= 1.7)
                for (const int way : {1, -1}) {
                    SCOPED_TRACE(space + ", " + precision + ", " + written(gap) + (way > 0 ? " up" : " down"));
                    const Double3 eye{0.3, 0.5, 1 - gap};
                    const std::string camera = "[camera]\nposition = [0.3, 0.5, " + written(eye[2]) +
                                               "]\nlook_at = [0.3, 0.4, " + written(eye[2] + way) + "]\nfov = 40\n";
                    Options options = with_strategy(GetParam());
                    options.precision = precision_named(precision);
                    const auto plan =
                        plan_of_text("[space]\n" + space +
                                         "\n[integrator]\nescape_radius = 4\n[film]\nsize = [8, 8]\n" + camera + room,
                                     {}, options);
                    ASSERT_NE(plan->job().camera, nullptr);
                    std::vector<RayEnd> ends(64);
                    Counters counters{};
                    const Tile all{0, 0, 8, 8};
                    const Job job = plan->job();
                    plan->run.kernel->trace(&job, &all, ends.data(), &counters);
                    for (const RayEnd& end : ends) {
                        ASSERT_EQ(end.status, Status::hit);
                        ASSERT_NEAR(std::max({std::abs(end.q[0]), std::abs(end.q[1]), std::abs(end.q[2])}), 1, 1e-6);
                        if (way > 0)
                            ASSERT_NEAR(std::hypot(end.q[0] - eye[0], end.q[1] - eye[1]), 0,
                                        gap);  // at most 40° from the normal
                        else ASSERT_LT(end.q[2], 0.5);
                    }
                }
}

// A ray that starts on the floor and bends away from it, however slowly: (5) has the path z = −2 − g λ²/4, which never
// returns.
TEST_P(FirstEdge, IsNotTheFloorThatIsLeft) {
    for (const char* g : {"1e-3", "1e-6"})
        for (const Overrides& how : {Overrides{}, {"integrator.step=0.01"}, {"integrator.method=gauss8"}}) {
            const std::string floor =
                "[[object]]\nname = \"floor\"\nshape = \"rectangle\"\norigin = [-20, -20, -2]\nedge_u = [40, 0, "
                "0]\nedge_v = [0, 40, 0]\n";
            const auto ends = ends_of(std::string("[space]\nhamiltonian = \"gradient\"\ng = ") + g +
                                          "\n[integrator]\nescape_radius = 50\n" + view + floor,
                                      how, {{{0, 0, -2}, {1, 0, 0}}});
            EXPECT_EQ(ends[0].status, Status::escaped) << g;
        }
}

// On the escape sphere, and along it: there it has left.
TEST_P(FirstEdge, MayBeTheEscapeSphereAtTheStart) {
    for (const char* space : {"hamiltonian = \"gradient\"\ng = 1e-3", "hamiltonian = \"luneburg\"",
                              "hamiltonian = \"schwarzschild\"", "hamiltonian = \"flat\""}) {
        const auto ends = ends_of(std::string("[space]\n") + space + "\n[integrator]\nescape_radius = 50\n" + view, {},
                                  {{{0, 50, 0}, {1, 0, 0}}});
        EXPECT_EQ(ends[0].status, Status::escaped) << space;
        EXPECT_NEAR(ends[0].q[1], 50, 1e-8) << space;
    }
}

// What passes through Ellis's throat, b < a (Müller 2004), does so by the coarsest steps, and the smallest throat.
TEST_P(FirstEdge, LiesBehindAThroatForRaysThatPassIt) {
    for (const double throat : {1.0, 1e-3, 1e-9})
        for (const Overrides& how : {Overrides{"integrator.method=rk4", "integrator.step=3"},
                                     {"integrator.method=dp5", "integrator.step=2"},
                                     {"integrator.symmetry=none"},
                                     {"integrator.method=rkf78", "integrator.rescale=none"}}) {
            std::vector<RayInput> rays;
            const double distance = 6 * std::max(throat, 0.1), areal = distance + 0.25 * throat * throat / distance;
            for (int i = 0; i < 20; ++i) {
                const double sine = 0.1 * (i + 0.5) * throat / areal;
                rays.push_back(
                    {{-distance, 0, 0}, {std::sqrt(1 - sine * sine), sine * std::cos(i), sine * std::sin(i)}});
            }
            const auto ends = ends_of("space = { hamiltonian = \"wormhole\", throat = " + written(throat) +
                                          " }\nintegrator.escape_radius = 20\n" + view,
                                      how, rays);
            for (std::size_t i = 0; i < ends.size(); ++i) {
                SCOPED_TRACE(testing::Message()
                             << "throat " << throat << ", " << how[0] << ", b/a = " << 0.1 * (double(i) + 0.5));
                ASSERT_EQ(ends[i].status, Status::escaped);
                EXPECT_EQ(std::hypot(ends[i].q[0], ends[i].q[1], ends[i].q[2]) < 0.5 * throat, i < 10);
            }
        }
}

INSTANTIATE_TEST_SUITE_P(Strategies, FirstEdge, testing::Values("scalar", "packet"),
                         [](const auto& chosen) { return std::string(chosen.param); });

}  // namespace
}  // namespace kagero::test
