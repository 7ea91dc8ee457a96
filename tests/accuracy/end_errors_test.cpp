// Tests of the error layer `position_error`, which estimates the errors of ray ends, and of the layers `newton` and
// `occupancy`.
#include "tests/support/end_errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <limits>

namespace kagero::test {
namespace {

/// A method with its step, or with its tolerance if the method is adaptive.
struct MethodStep {
    const char* method;
    double step;
};

/// Renders a scene and expects that the layer `position_error` is within a factor of 3 of the true error for at least
/// 95 % of the pixels. The true error is the distance of the computed ray end from the closed form `exact`.
void expect_estimates(const char* scene, const MethodStep& run, const ExactEnd& exact, const std::string& precision) {
    SCOPED_TRACE(run.method);
    const Comparison compared =
        compare(scene, run.method, run.step, exact, "position_error", precision, precision == "float" ? 0.2 : 1000);
    ASSERT_GT(compared.pairs.size(), 1000u);
    EXPECT_LT(compared.without_estimate, 50u);
    EXPECT_GE(compared.share_within(3), 0.95);
    ::testing::Test::RecordProperty(std::string("within_2_") + run.method + "_" + precision,
                                    std::to_string(compared.share_within(2)));
}

TEST(PositionError, IsWithinAFactorOf3OfTheTrueErrorAroundABlackHole) {
    for (const MethodStep& run : {MethodStep{"verlet", 0.05},
                                  {"suzuki4-nine", 0.1},
                                  {"rk4", 0.05},
                                  {"gauss4", 0.1},
                                  {"gauss8", 0.3},
                                  {"dp54", 1e-6}})
        expect_estimates(hole_scene, run, exact_escape, "double");
    // With these tolerances, the step bound of the space limits the steps, and not the tolerance.
    for (const MethodStep& run : {MethodStep{"dp54", 0.1}, {"rkf78", 1e-3}, {"dp85", 1e-3}})
        expect_estimates(hole_scene, run, exact_escape, "double");
    expect_estimates(hole_scene, {"gauss8", 0.1}, exact_escape, "float");
}

TEST(PositionError, IsWithinAFactorOf3OfTheTrueErrorInAFisheye) {
    for (const MethodStep& run : {MethodStep{"verlet", 0.02},
                                  {"srkn6", 0.1},
                                  {"rk4", 0.05},
                                  {"gauss4", 0.1},
                                  {"gauss8", 0.3},
                                  {"dp54", 1e-6}})
        expect_estimates(fisheye_scene, run, exact_hit, "double");
    expect_estimates(fisheye_scene, {"rk4", 0.02}, exact_hit, "float");
}

// If hits are computed on the chords of the steps, the error of the chords dominates. It is of second order in the
// step, for every method. A step that is 4 times as long gives an error that is 16 times as large. The tolerance of 6
// allows for orders between 1.7 and 2.2.
TEST(PositionError, IsOfSecondOrderIfHitsLieOnChords) {
    const auto median = [](double step) {
        const auto plan = plan_of_file(KAGERO_SCENES "/room.toml",
                                       {"film.size=[48,48]", "integrator.hit=chord", "integrator.method=rk4",
                                        "integrator.step=" + std::to_string(step)});
        Film film(48, 48, {"position_error"});
        render_with_errors(*plan, film);
        const float* errors = film.plane("position_error");
        std::vector<double> positive;
        std::copy_if(errors, errors + 48 * 48, std::back_inserter(positive), [](float error) { return error > 0; });
        return percentiles_of(std::move(positive)).p50;
    };
    EXPECT_NEAR(median(0.06) / median(0.015), 16, 6);
}

// The layer is NaN if the error cannot be estimated: for rays that reach the step limit, and for rays whose status or
// object differs in the second run, which has shorter steps. It is 0 for rays that are captured in both runs.
TEST(PositionError, IsNaNWithoutARayEndAndZeroForCapturedRays) {
    const auto plan = plan_of_text(hole_scene, {"integrator.method=\"gauss8\"", "integrator.max_steps=20"});
    Film film(48, 48, {"status", "position_error"});
    render_with_errors(*plan, film);
    std::size_t captured = 0, limited = 0;
    for (std::size_t i = 0; i < 48 * 48; ++i) {
        const auto status = static_cast<Status>(static_cast<int>(film.plane("status")[i]));
        const float error = film.plane("position_error")[i];
        EXPECT_TRUE(std::isnan(error) || error >= 0);
        if (status == Status::step_limit) {
            EXPECT_TRUE(std::isnan(error));
            ++limited;
        }
        if (status != Status::captured || std::isnan(error)) continue;
        EXPECT_EQ(error, 0);
        ++captured;
    }
    EXPECT_GT(captured, 10u);
    EXPECT_GT(limited, 10u);
}

// The layer `newton` contains the number of iterations of implicit solves. It is the same with the strategies `packet`
// and `scalar`, and 0 for explicit methods. A packet of one ray always has occupancy 1. The least occupancy of a pixel
// is at most the occupancy of the whole picture, which is the ratio of two counters.
TEST(IterationLayers, HaveTheSameIterationsForPacketsAndSingleRaysAndOccupanciesOfAtMostOne) {
    Film packets(48, 48, {"occupancy", "newton", "steps"}), single(48, 48, {"occupancy", "newton"});
    RunReport report;
    double least = 1;
    for (const char* method : {"gauss8", "verlet"}) {
        const Overrides overrides{std::string("integrator.method=") + method, "integrator.step=0.8"};
        const auto packet_plan = plan_of_text(hole_scene, overrides);
        const auto scalar_plan = plan_of_text(hole_scene, overrides, with_strategy("scalar"));
        report = render(*packet_plan, packets);
        render(*scalar_plan, single);
        least = 1;
        for (std::size_t i = 0; i < 48 * 48; ++i) {
            EXPECT_EQ(packets.plane("newton")[i], single.plane("newton")[i]) << method;
            EXPECT_GE(packets.plane("newton")[i], packets.plane("steps")[i]) << method;
            EXPECT_EQ(single.plane("occupancy")[i], 1);
            EXPECT_LE(packets.plane("occupancy")[i], 1);
            least = std::min(least, double(packets.plane("occupancy")[i]));
        }
    }
    const double mean = double(report.counters.active_lane_steps) / double(report.counters.issued_lane_steps);
    EXPECT_GT(least, 0);
    EXPECT_LE(least, mean);
    const auto explicit_method = plan_of_text(hole_scene, {"integrator.method=\"rk4\""});
    render(*explicit_method, packets);
    for (std::size_t i = 0; i < 48 * 48; ++i) EXPECT_EQ(packets.plane("newton")[i], 0);
}

}  // namespace
}  // namespace kagero::test
