// Tests of `--precision auto`, which chooses float if the difference from double is invisible in the picture.
#include "tests/support/plan_fixture.h"
#include "tests/support/sample_error.h"

#include "tuning/precision.h"

#include <gtest/gtest.h>

namespace kagero::test {
namespace {

/// Returns the plan of a scene file with the chosen precision.
std::unique_ptr<Plan> plan_with_chosen_precision(const std::string& scene, const Overrides& overrides = {},
                                                 const Options& options = {}) {
    auto plan = plan_of_file(scene_file(scene), overrides, options);
    *plan = choose_precision(*plan);
    return plan;
}

TEST(Precision, IsFloatIfTheDifferenceIsInvisible) {
    for (const char* scene : {"room.toml", "galaxy.toml", "mirage.toml", "luneburg.toml", "kerr.toml"}) {
        SCOPED_TRACE(scene);
        const auto plan = plan_with_chosen_precision(scene);
        ASSERT_EQ(plan->run.kernel->precision, Precision::float32) << plan->precision_trial->reason_for_double;
        EXPECT_LE(plan->precision_trial->difference, 0.1);
        const auto in_double = plan_of_file(scene_file(scene), {});
        // The grid of 27 × 27 rays has no ray in common with the grid of the trial.
        EXPECT_LE(p99_pixel_error(*plan, 27), p99_pixel_error(*in_double, 27) + 0.1);
    }
}

// The camera looks at the ball from so far that rounding a position to float displaces it by more than a pixel.
TEST(Precision, IsDoubleIfFloatIsVisible) {
    const std::string far =
        "[space]\nhamiltonian = \"schwarzschild\"\nrg = 0.08\n[integrator]\nescape_radius = 4e4\nmax_steps = 100000\n"
        "[camera]\nposition = [20000, 0, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\nfov = 0.003\n[film]\nsize = [512, "
        "512]\n"
        "[[object]]\nname = \"ball\"\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 0.4\n";
    const auto plan = plan_of_text(far, {});
    *plan = choose_precision(*plan);
    EXPECT_EQ(plan->run.kernel->precision, Precision::float64);
    EXPECT_GT(plan->precision_trial->rays, 0u);
    EXPECT_FALSE(plan->precision_trial->reason_for_double.empty());
}

// No trial is made if double is requested, if float would not be faster, or if float would not be accurate enough.
TEST(Precision, IsDoubleWithoutATrialIfFloatIsNoOption) {
    const auto is_double = [](const Overrides& overrides, const Options& options = {}) {
        const auto plan = plan_with_chosen_precision("room.toml", overrides, options);
        return plan->run.kernel->precision == Precision::float64 && plan->precision_trial->rays == 0 &&
               !plan->precision_trial->reason_for_double.empty();
    };
    Options in_double;
    in_double.precision = Precision::float64;
    EXPECT_TRUE(is_double({}, in_double));
    EXPECT_TRUE(is_double({}, with_strategy("scalar")));
    EXPECT_TRUE(is_double({"film.size=[64,64]"}));
    EXPECT_TRUE(is_double({"film.layers=[\"color\",\"energy_error\"]"}));
    EXPECT_TRUE(is_double({"integrator.method=\"dp54\"", "integrator.tolerance=1e-9"}));
}

// Near a horizon, the momenta of camera rays are too large for float, so that no trial is made.
TEST(Precision, IsDoubleNearAHorizon) {
    const std::string near =
        "[space]\nhamiltonian = \"schwarzschild\"\nrg = 1\n[camera]\nposition = [1.0001, 0, 0]\nlook_at = [9, 0, 0]\n"
        "up = [0, 0, 1]\n[film]\nsize = [256, 256]\n";
    const auto plan = plan_of_text(near, {});
    *plan = choose_precision(*plan);
    EXPECT_EQ(plan->run.kernel->precision, Precision::float64);
    EXPECT_NE(plan->precision_trial->reason_for_double.find("horizon"), std::string::npos);
}

// On a large escape sphere, the rounding of a position in float is larger than the usual tolerance of refinement. The
// rays must escape nevertheless.
TEST(Precision, LetsFloatRaysEscapeFromALargeSphere) {
    const std::string nearly_straight =
        "[space]\nhamiltonian = \"gradient\"\ng = 1e-6\n[integrator]\nescape_radius = 1000\n"
        "[camera]\nposition = [0.3, -8, 1]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\nfov = 70\n[film]\nsize = [128, 128]\n";
    Options in_float;
    in_float.precision = Precision::float32;
    const auto plan = plan_of_text(nearly_straight, {}, in_float);
    Film film(128, 128, {"color"});
    EXPECT_EQ(render(*plan, film).counters.ended[static_cast<int>(Status::escaped)], 128u * 128u);
}

}  // namespace
}  // namespace kagero::test
