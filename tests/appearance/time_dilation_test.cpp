// Tests the table of the time dilation of matter on circular orbits.
#include "spaces/time_dilation.h"
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

namespace kagero::test {
namespace {

// Schwarzschild: dt/dτ = 1/√(1 − 3M/r).
TEST(TimeDilation, EqualsTheClosedFormOutsideTheLightOrbit) {
    const auto exact = [](double r) { return 1 / std::sqrt(1 - 3 / r); };
    const TimeDilation table(2.5, 40, exact);
    std::size_t tabulated = 0;
    for (double r = 2.6; r < 40; r += 0.013) {
        const double value = table.at(r);
        if (std::isnan(value)) continue;
        ++tabulated;
        EXPECT_NEAR(value / exact(r), 1, 1e-9) << r;
    }
    EXPECT_GT(tabulated, 2600u);  // of 2877; only close to the light orbit, the table is not accurate
    EXPECT_TRUE(std::isnan(table.at(2.4)));
    EXPECT_TRUE(std::isnan(table.at(2.9)));
    EXPECT_TRUE(std::isnan(table.at(41)));
    EXPECT_TRUE(std::isnan(TimeDilation().at(5)));
}

TEST(TimeDilation, GivesTheRedshiftOfTheMetric) {
    const auto plan = plan_of_file(scene_file("kerr.toml"), {"film.size=[64,48]"});
    Sources without_table = plan->scene->sources;
    without_table.dilations.clear();
    std::vector<RayEnd> ends;
    Counters counters{};
    trace_tile(*plan->run.kernel, plan->job(), plan->view.window, {}, ends, counters);
    std::size_t compared = 0;
    const CameraRay start{{}, 1};
    for (const RayEnd& end : ends) {
        if (end.status != Status::hit) continue;
        PixelSample sample;
        sample.end = &end;
        sample.ray = &start;
        const double expected = kagero::redshift_of(without_table, true, sample);
        EXPECT_NEAR(kagero::redshift_of(plan->scene->sources, true, sample), expected, 1e-7 * expected);
        ++compared;
    }
    EXPECT_GT(compared, 100u);
}

}  // namespace
}  // namespace kagero::test
