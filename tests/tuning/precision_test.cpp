// --precision auto: float where a picture cannot tell it from double, and nowhere else.
#include "tests/support/plan_fixture.h"
#include "tests/support/sample_error.h"

#include "tuning/precision.h"

#include <gtest/gtest.h>

namespace kagero::test {
namespace {

std::unique_ptr<Plan> chosen(const std::string& scene, const Overrides& overrides = {}, const Options& options = {}) {
    auto plan = plan_of_file(scene_file(scene), overrides, options);
    *plan = choose_precision(*plan);
    return plan;
}

TEST(Precision, IsFloatWhereItCannotBeSeen) {
    for (const char* scene : {"room.toml", "galaxy.toml", "mirage.toml", "luneburg.toml", "kerr.toml"}) {
        SCOPED_TRACE(scene);
        const auto plan = chosen(scene);
        ASSERT_EQ(plan->run.kernel->precision, Precision::float32) << plan->precision_trial->why_not;
        EXPECT_LE(plan->precision_trial->apart, 0.1);
        const auto in_double = plan_of_file(scene_file(scene), {});
        EXPECT_LE(error_of(*plan, 27), error_of(*in_double, 27) + 0.1);  // a grid that shares no ray with the trial's
    }
}

/// The camera looks past the hole at a ball from so far that float's places are coarser than pixels.
TEST(Precision, IsDoubleWhereFloatWouldShow) {
    const std::string far =
        "[space]\nhamiltonian = \"schwarzschild\"\nrg = 0.08\n[integrator]\nescape_radius = 4e4\nmax_steps = 100000\n"
        "[camera]\nposition = [20000, 0, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\nfov = 0.003\n[film]\nsize = [512, "
        "512]\n"
        "[[object]]\nname = \"ball\"\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 0.4\n";
    const auto plan = plan_of_text(far, {});
    *plan = choose_precision(*plan);
    EXPECT_EQ(plan->run.kernel->precision, Precision::float64);
    EXPECT_GT(plan->precision_trial->rays, 0u);
    EXPECT_FALSE(plan->precision_trial->why_not.empty());
}

TEST(Precision, IsDoubleWhereItIsAskedForOrNothingIsGained) {
    const auto stays = [](const Overrides& overrides, const Options& options = {}) {
        const auto plan = chosen("room.toml", overrides, options);
        return plan->run.kernel->precision == Precision::float64 && plan->precision_trial->rays == 0 &&
               !plan->precision_trial->why_not.empty();
    };
    Options in_double;
    in_double.precision = Precision::float64;
    EXPECT_TRUE(stays({}, in_double));
    EXPECT_TRUE(stays({}, with_strategy("scalar")));
    EXPECT_TRUE(stays({"film.size=[64,64]"}));
    EXPECT_TRUE(stays({"film.layers=[\"color\",\"energy_error\"]"}));
    EXPECT_TRUE(stays({"integrator.method=\"dp54\"", "integrator.tolerance=1e-9"}));
}

/// Beside a horizon float loses the momentum before the first step: there is nothing to try.
TEST(Precision, IsDoubleBesideAHorizon) {
    const std::string near =
        "[space]\nhamiltonian = \"schwarzschild\"\nrg = 1\n[camera]\nposition = [1.0001, 0, 0]\nlook_at = [9, 0, 0]\n"
        "up = [0, 0, 1]\n[film]\nsize = [256, 256]\n";
    const auto plan = plan_of_text(near, {});
    *plan = choose_precision(*plan);
    EXPECT_EQ(plan->run.kernel->precision, Precision::float64);
    EXPECT_NE(plan->precision_trial->why_not.find("horizon"), std::string::npos);
}

/// Far out a float's last place is more of a step than landing comes close to; the ray has arrived all the same.
TEST(Precision, FloatReachesFarSpheres) {
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
