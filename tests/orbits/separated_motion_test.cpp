// Tests methods that integrate rays around a spinning hole by their separated motion in Mino time. The ends are
// compared with an independent integration in Boyer–Lindquist coordinates, and with rays on the general path.
#include "tests/support/kerr_rays.h"

#include "error.h"
#include "render/render.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace kagero::test {
namespace {

constexpr const char* fine = "method = \"mino-srkn14\"\nstep = 0.05\n";

/// Returns the plan for rays around a hole of mass 1 with the given lines in the section [integrator].
std::unique_ptr<Plan> plan_around_hole(double spin, const std::string& integrator, const std::string& observer = "",
                                       const char* strategy = "packet", const char* precision = "double") {
    const std::string scene =
        "space = { hamiltonian = \"kerr\", spin = " + std::to_string(spin) +
        " }\n[integrator]\nescape_radius = 40\nmax_steps = 20000\n" + integrator +
        "[camera]\nposition = [0, -10, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [4, 4]\n";
    Options options = with_strategy(strategy);
    options.observer = observer_of(observer);
    options.precision = precision_named(precision);
    return plan_of_text(scene, {}, options, false);
}

/// Returns rays in even directions from places far from the hole and close to it, on the equator and on the axis.
std::vector<RayInput> rays_from_everywhere(double spin, double least_radius) {
    std::vector<RayInput> rays;
    for (const double r : {least_radius, 4.0, 15.0})
        for (const double theta : {0.0, 0.7, 1.5707963267948966, 3.0})
            for (const Double3& d : even_directions(20)) rays.push_back({position_at(spin, r, theta, 0.4 + r), d});
    return rays;
}

/// Expects that every ray that is not critical ends as the reference does, within `tolerance` times its conditioning.
void expect_reference_ends(const Plan& plan, const std::vector<RayStart>& starts, double tolerance,
                           std::size_t least_escaped) {
    const auto ends = traced(plan, starts);
    std::size_t escaped = 0;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        if (starts[i].failure != Failure::none) continue;
        const KerrGeodesic ray = geodesic_of(plan, starts[i]);
        if (is_critical(ray)) continue;
        SCOPED_TRACE(testing::Message() << "ray " << i);
        ASSERT_EQ(ends[i].status, ray.escape_margin() > 0 ? Status::escaped : Status::captured);
        if (ends[i].status != Status::escaped) continue;
        const auto reference = reference_end(ray, beyond_sphere(40));
        ASSERT_TRUE(reference);
        EXPECT_LT(distance_between(reference->place, ends[i]), tolerance * reference->conditioning);
        ++escaped;
    }
    EXPECT_GE(escaped, least_escaped);
}

class SeparatedMotion : public testing::TestWithParam<const char*> {};

// The step of a nearly radial ray is a share of the distance from the hole, however small the angle h is. Its error is
// about 1e-9.
TEST_P(SeparatedMotion, RaysEndWhereTheReferenceEnds) {
    for (const double spin : {0.0, 0.3, -0.7, 0.998, 1.0}) {
        SCOPED_TRACE(spin);
        const auto plan = plan_around_hole(spin, fine, "", GetParam());
        expect_reference_ends(*plan, start_rays(*plan, rays_from_everywhere(spin, 2.2)), 1e-9, 130);
    }
}

// The rays of a static observer exist outside the ergosphere. Observers without angular momentum exist close to the
// horizon, and falling observers also inside it.
TEST_P(SeparatedMotion, RaysFromNearAndInsideTheHorizonEndWhereTheReferenceEnds) {
    const struct {
        const char* observer;
        double radius;              ///< in units of the horizon's radius
        std::size_t least_escaped;  ///< of 120 rays; few directions lead away from the horizon
    } cases[] = {
        {"zamo", 1.01, 0}, {"zamo", 1.2, 10}, {"falling", 1.5, 80}, {"falling", 1.001, 50}, {"falling", 0.8, 20}};
    for (const double spin : {0.6, 0.95, -0.998})
        for (const auto& [observer, radius, least_escaped] : cases) {
            SCOPED_TRACE(testing::Message() << observer << " at " << radius << " r+, spin " << spin);
            const auto plan = plan_around_hole(spin, fine, observer, GetParam());
            const double r = radius * (1 + std::sqrt(1 - spin * spin));
            std::vector<RayInput> rays;
            for (const double theta : {0.1, 1.2})
                for (const Double3& d : even_directions(60)) rays.push_back({position_at(spin, r, theta, 2), d});
            expect_reference_ends(*plan, start_rays(*plan, rays, observer_of(observer)), 1e-9, least_escaped);
        }
}
INSTANTIATE_TEST_SUITE_P(Strategies, SeparatedMotion, testing::Values("scalar", "packet"));

// Prograde rays turn the closer to the horizon, the closer their impact parameter is to the critical one. On the
// equator around a hole of spin 1, the radius of the turning point tends to that of the horizon.
TEST(SeparatedMotionNearCritical, RaysThatTurnCloseToTheHorizonEndWhereTheReferenceEnds) {
    for (const double spin : {0.95, 0.998, 1.0}) {
        SCOPED_TRACE(spin);
        const auto plan = plan_around_hole(spin, "method = \"mino-srkn14\"\nstep = 0.02\n", "zamo");
        const double critical = 6 * std::cos(std::acos(-spin) / 3) - spin;  // Chandrasekhar (1983), §61, eq. 82
        std::vector<RayInput> rays;
        for (const double excess : {1e-1, 1e-2, 1e-3, 1e-4}) {
            const double angle = (critical + excess) / std::sqrt(20.0 * 20.0 + 2);
            for (const double height : {0.0, 1e-3}) rays.push_back({{0, -20, height}, {-angle, 1, 0.1 * height}});
        }
        expect_reference_ends(*plan, start_rays(*plan, rays, ObserverKind::zamo), 1e-10, 5);
    }
}

// Position, momentum, λ and the energy error are compared with those of Hamilton's equations for H.
TEST(SeparatedMotionStates, MatchTheGeneralPath) {
    for (const double spin : {0.5, 0.95}) {
        const auto rays = rays_from_everywhere(spin, 3);
        const auto general = plan_around_hole(spin, "method = \"gauss16\"\nstep = 0.1\n"),
                   separated = plan_around_hole(spin, fine);
        const auto expected = traced(*general, start_rays(*general, rays)),
                   ends = traced(*separated, start_rays(*separated, rays));
        int compared = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (expected[i].status != Status::escaped || expected[i].parameter > 75) continue;  // near-critical
            SCOPED_TRACE(testing::Message() << "spin " << spin << ", ray " << i);
            ASSERT_EQ(ends[i].status, Status::escaped);
            for (int k = 0; k < 3; ++k) {
                EXPECT_NEAR(ends[i].q[k], expected[i].q[k], 2e-8);
                EXPECT_NEAR(ends[i].p[k], expected[i].p[k], 2e-9);
                EXPECT_NEAR(ends[i].v[k], expected[i].v[k], 2e-9);
            }
            EXPECT_NEAR(ends[i].parameter, expected[i].parameter, 1e-8);
            EXPECT_LT(ends[i].energy_error, 1e-10);
            ++compared;
        }
        EXPECT_GT(compared, 100);
    }
}

TEST(SeparatedMotionStates, MatchDoubleInFloat) {
    const auto rays = rays_from_everywhere(0.95, 3);
    const auto in_double = plan_around_hole(0.95, "method = \"mino-srkn11\"\nstep = 0.3\n"),
               in_float = plan_around_hole(0.95, "method = \"mino-srkn11\"\nstep = 0.3\n", "", "packet", "float");
    const auto starts = start_rays(*in_double, rays);
    const auto expected = traced(*in_double, starts), ends = traced(*in_float, starts);
    std::vector<double> errors;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (is_critical(geodesic_of(*in_double, starts[i]))) continue;
        ASSERT_EQ(ends[i].status, expected[i].status) << i;
        if (ends[i].status == Status::escaped)
            errors.push_back(std::hypot(ends[i].v[0] - expected[i].v[0], ends[i].v[1] - expected[i].v[1],
                                        ends[i].v[2] - expected[i].v[2]));
    }
    std::sort(errors.begin(), errors.end());
    EXPECT_LT(errors[errors.size() * 9 / 10], 5e-6);
}

// The action and the coordinate time are integrals over the same path.
TEST(SeparatedMotionStates, IntegralsMatchTheGeneralPath) {
    const auto ends_with = [](const std::string& integrator) {
        Options options = with_strategy("packet");
        options.observer = observer_of("zamo");
        options.action = options.time = true;
        const auto plan =
            plan_of_text("space = { hamiltonian = \"kerr\", spin = 0.9 }\n[integrator]\nescape_radius = 20\n" +
                             integrator +
                             "[camera]\nposition = [0, -10, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n"
                             "[film]\nsize = [4, 4]\n",
                         {}, options, false);
        std::vector<RayInput> rays;
        for (int k = 0; k < 16; ++k) rays.push_back({{1, -8, 2}, {0.5 + 0.02 * k, 1, 0.3 - 0.01 * k}});
        return traced(*plan, start_rays(*plan, rays, ObserverKind::zamo));
    };
    const auto expected = ends_with("method = \"dp85\"\ntolerance = 1e-13\n"), ends = ends_with(fine);
    for (std::size_t i = 0; i < ends.size(); ++i) {
        ASSERT_EQ(ends[i].status, Status::escaped) << i;
        EXPECT_GT(std::abs(expected[i].time), 10) << i;
        EXPECT_NEAR(ends[i].action, expected[i].action, 1e-7) << i;
        EXPECT_NEAR(ends[i].time, expected[i].time, 1e-7) << i;
    }
}

TEST(SeparatedMotionScenes, HitsMatchTheGeneralPath) {
    const auto render_disk = [](const Overrides& overrides) {
        auto settings = overrides;
        settings.push_back("film.size=[96, 64]");
        settings.push_back("film.layers=[\"status\", \"object\", \"depth\"]");
        const auto plan = plan_of_file(scene_file("kerr.toml"), settings, with_strategy("packet"));
        Film film(96, 64, plan->description().film.layers);
        render(*plan, film, {});
        return film;
    };
    const Film general = render_disk({"integrator.method=gauss12", "integrator.step=0.1"});
    for (const char* step : {"integrator.step=0.3", "integrator.step=1.5", "integrator.step=1000"}) {
        const Film separated = render_disk({"integrator.method=mino-srkn11", step});
        int different = 0, hits = 0;
        for (std::size_t i = 0; i < 96 * 64; ++i) {
            hits += general.plane("status")[i] == float(Status::hit);
            const bool same = separated.plane("status")[i] == general.plane("status")[i] &&
                              separated.plane("object")[i] == general.plane("object")[i];
            const float error = std::abs(separated.plane("depth")[i] - general.plane("depth")[i]);
            different += !same || error > 1e-3f;
        }
        EXPECT_GT(hits, 1000);
        EXPECT_LE(different, 6) << step;
    }
}

TEST(SeparatedMotionChoice, IsTheDefaultAroundAHoleAndRefusedElsewhere) {
    const auto method_of = [](const Overrides& overrides) {
        return std::string(plan_of_file(scene_file("kerr.toml"), overrides)->method().name);
    };
    EXPECT_EQ(method_of({}), "mino-srkn11");
    for (const char* setting : {"integrator.symmetry=none", "integrator.tolerance=1e-4", "integrator.rescale=none"})
        EXPECT_EQ(method_of({setting}).find("mino"), std::string::npos) << setting;
    EXPECT_THROW(method_of({"integrator.symmetry=none", "integrator.method=mino-srkn6"}), InputError);
    EXPECT_THROW(plan_of_file(scene_file("hole.toml"), {"integrator.method=mino-srkn6"}), InputError);
}

}  // namespace
}  // namespace kagero::test
