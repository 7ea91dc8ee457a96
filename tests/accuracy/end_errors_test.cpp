// The layer that says how far off a picture's rays end, and those of what a ray needed.
#include "tests/support/end_errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <limits>

namespace kagero::test {
namespace {

struct Way {
    const char* method;
    double step;
};

void expect_estimates(const char* scene, const Way& way, const Exact& exact, const std::string& precision) {
    SCOPED_TRACE(way.method);
    const Compared compared =
        compare(scene, way.method, way.step, exact, "position_error", precision, precision == "float" ? 0.2 : 1000);
    ASSERT_GT(compared.pairs.size(), 1000u);
    EXPECT_LT(compared.unknown, 50u);
    EXPECT_GE(compared.share_within(3), 0.95);
    ::testing::Test::RecordProperty(std::string("within_2_") + way.method + "_" + precision,
                                    std::to_string(compared.share_within(2)));
}

TEST(PositionError, IsTheTrueErrorAroundAHole) {
    for (const Way& way :
         {Way{"verlet", 0.05}, {"suzuki4-nine", 0.1}, {"rk4", 0.05}, {"gauss4", 0.1}, {"gauss8", 0.3}, {"dp54", 1e-6}})
        expect_estimates(hole_scene, way, exact_escape, "double");
    // Where the space bounds steps, and not the tolerance.
    for (const Way& way : {Way{"dp54", 0.1}, {"rkf78", 1e-3}, {"dp85", 1e-3}})
        expect_estimates(hole_scene, way, exact_escape, "double");
    expect_estimates(hole_scene, {"gauss8", 0.1}, exact_escape, "float");
}

TEST(PositionError, IsTheTrueErrorInAFisheye) {
    for (const Way& way :
         {Way{"verlet", 0.02}, {"srkn6", 0.1}, {"rk4", 0.05}, {"gauss4", 0.1}, {"gauss8", 0.3}, {"dp54", 1e-6}})
        expect_estimates(fisheye_scene, way, exact_hit, "double");
    expect_estimates(fisheye_scene, {"rk4", 0.02}, exact_hit, "float");
}

// Where hits lie on chords the error is that of the picture's chords, of second order, whatever else the rays are
// traced by.
TEST(PositionError, OfChordsFallsWithTheStep) {
    const auto median = [](double step) {
        const auto plan = plan_of_file(KAGERO_SCENES "/room.toml",
                                       {"film.size=[48,48]", "integrator.hit=chord", "integrator.method=rk4",
                                        "integrator.step=" + std::to_string(step)});
        Film film(48, 48, {"position_error"});
        render_with_errors(*plan, film);
        const float* errors = film.plane("position_error");
        std::vector<double> known;
        std::copy_if(errors, errors + 48 * 48, std::back_inserter(known), [](float error) { return error > 0; });
        return spread_of(std::move(known)).p50;
    };
    EXPECT_NEAR(median(0.06) / median(0.015), 16, 6);
}

// Nothing is known of a ray that ends elsewhere when it is traced otherwise; of one that is captured there is nothing
// to know.
TEST(PositionError, IsNotANumberWhereThereIsNone) {
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

// What a ray needs does not depend on the strategy; a packet of one ray is always full.
TEST(IterationsAndOccupancy, BelongToRaysAndToPackets) {
    Film packets(48, 48, {"occupancy", "newton", "steps"}), single(48, 48, {"occupancy", "newton"});
    RunReport report;
    double least = 1;
    for (const char* method : {"gauss8", "verlet"}) {
        const Overrides how{std::string("integrator.method=") + method, "integrator.step=0.8"};
        const auto in_packets = plan_of_text(hole_scene, how),
                   alone = plan_of_text(hole_scene, how, with_strategy("scalar"));
        report = render(*in_packets, packets);
        render(*alone, single);
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
