// The time and the action of rays near a black hole, which are in ingoing coordinates on a part of their way.
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kagero::test {
namespace {

// A ray that moves radially outward is followed in ingoing coordinates near the hole, and for a falling observer. Its
// time is that of the outgoing coordinates, r_start − r_end − 2 ln((r_end − 1)/(r_start − 1)). A ray that starts inside
// the horizon has the time of the reversed ingoing coordinates, r_end − r_start.
TEST(ChartIntegrals, BelongToTheOutgoingFormOutsideTheHorizon) {
    const std::string scene =
        "[space]\nhamiltonian = \"schwarzschild\"\nrg = 1\n[camera]\nposition = [0, 0, 9]\nlook_at = [0, 0, 0]\n"
        "[film]\nsize = [4, 4]\n";
    for (const char* strategy : {"scalar", "packet"})
        for (const auto& observer : {std::optional<ObserverKind>{}, std::optional(ObserverKind::falling)}) {
            Options options = with_strategy(strategy);
            options.action = options.time = true;
            options.observer = observer;
            const auto plan = plan_of_text(scene, {}, options, false);
            for (const double start : {0.5, 1.05, 1.5, 4.0}) {
                if (start < 1 && !observer) continue;
                std::vector<RayEnd> ends;
                trace(*plan, start_rays(*plan, {{{start, 0, 0}, {1, 0, 0}}}, observer), ends);
                const double expected = start < 1 ? 50 - start : start - 50 - 2 * std::log(49 / (start - 1));
                ASSERT_EQ(ends[0].status, Status::escaped);
                EXPECT_NEAR(ends[0].time, expected, 1e-9) << "start " << start;
                EXPECT_NEAR(ends[0].action, -ends[0].pt * ends[0].time, 1e-9) << "start " << start;
            }
        }
}

}  // namespace
}  // namespace kagero::test
