// Tests of integrator.max_pixel_error: the method and step that a trial chooses must meet the bound for other rays too.
#include "tests/support/hole_scene.h"
#include "tests/support/plan_fixture.h"
#include "tests/support/sample_error.h"

#include "error.h"
#include "study/error_study.h"
#include "tuning/choose_method.h"
#include "tuning/precision.h"
#include "tuning/resolve.h"
#include "tuning/step_bound.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace kagero::test {
namespace {

using nlohmann::json;

class MaxPixelError : public HoleTest {};

// The error is measured with a grid of 27 × 27 rays, which differs from the grid of the trial.
TEST_F(MaxPixelError, IsMetByRaysThatAreNotInTheTrial) {
    for (const char* scene : {"room", "galaxy", "mirage", "kerr"}) {
        for (const double bound : {0.25, 1e-3}) {
            SCOPED_TRACE(scene);
            const std::string path = std::string(KAGERO_SCENES) + "/" + scene + ".toml";
            ASSERT_TRUE(std::filesystem::exists(path));
            const auto plan = plan_of_file(path, {"integrator.max_pixel_error=" + std::to_string(bound)});
            *plan = choose_method(*plan);
            ASSERT_TRUE(plan->method_trial && plan->method_trial->bound_met);
            EXPECT_LE(plan->method_trial->estimate, bound);
            // The 99th percentiles of two samples of about a thousand rays differ by less than a factor of two.
            EXPECT_LE(p99_pixel_error(*plan, 27), 2 * bound);
        }
    }
}

// Both trials of a picture end if the caller sets `stop`.
TEST_F(MaxPixelError, TrialsCanBeInterrupted) {
    const std::atomic<bool> stop = true;
    const auto plan = plan_of_text(hole, {"film.size=[512,512]"});
    EXPECT_THROW(choose_method(*plan, {.stop = &stop}), Interrupted);
    EXPECT_THROW(choose_precision(*plan, &stop), Interrupted);
    EXPECT_THROW(choose_by_trial(*plan, {.stop = &stop}), Interrupted);
    EXPECT_TRUE(choose_by_trial(*plan).method_trial->bound_met);
}

// The trial that finds the step bound of a formula ends if the caller sets `stop`. Its operations are part of the third
// of the picture's operations that all trials together may need.
TEST_F(MaxPixelError, TheTrialOfAStepBoundCanBeInterruptedAndIsCounted) {
    const auto plan = plan_of_text(R"toml([space]
hamiltonian = "formula"
H = "0.5*(px^2 + py^2 + pz^2 - 1 - exp(-(x^2 + y^2 + z^2)))"
[integrator]
escape_radius = 20
[camera]
position = [-5, 0, 0]
look_at = [0, 0, 0]
up = [0, 0, 1]
[film]
size = [32, 32]
)toml", {});
    const std::atomic<bool> stop = true;
    EXPECT_THROW(choose_step_bound(*plan, {}, Purpose::picture, {.stop = &stop}), Interrupted);
    Plan bounded = choose_step_bound(*plan, {}, Purpose::picture);
    EXPECT_GT(bounded.trial_operations, 0);
    EXPECT_TRUE(choose_method(bounded).method_trial->bound_met);
    bounded.trial_operations = 1e18;  // more than any picture permits
    EXPECT_NE(choose_method(bounded).method_trial->failure_reason.find("operations"), std::string::npos);
}

// A camera with zero angular momentum close to the horizon of a fast spinning hole. Rays wind around it many times, so
// that the first tolerance of `dp54` does not confirm the reference, but a finer one does.
TEST_F(MaxPixelError, IsConfirmedByAFinerToleranceOfOneMethod) {
    const std::string near_horizon = R"toml([space]
hamiltonian = "kerr"
mass = 1
spin = 0.9999
[integrator]
escape_radius = 100
[camera]
position = [0, -1.431316317161638, 0]
look_at = [0, -3, 0]
up = [0, 0, 1]
fov = 100
observer = "zamo"
[film]
size = [160, 120]
)toml";
    for (const char* size : {"film.size=[160,120]", "film.size=[320,240]"}) {
        SCOPED_TRACE(size);
        Plan plan = choose_by_trial(*plan_of_text(near_horizon, {size}));
        ASSERT_TRUE(plan.method_trial->bound_met) << plan.method_trial->failure_reason;
        EXPECT_TRUE(plan.method_trial->remarks.empty());
        EXPECT_LE(p99_pixel_error(plan, 27), 2 * default_max_pixel_error);
    }
}

TEST_F(MaxPixelError, IsReported) {
    const Outcome met = run("render hole.toml --size 32x16 -o a.exr --quiet --json -D integrator.max_pixel_error=0.25");
    EXPECT_EQ(met.status, 0) << met.err;
    EXPECT_LE(json::parse(met.out)["pixel_error_estimate"], 0.25);
    EXPECT_EQ(json::parse(met.out)["max_pixel_error"], 0.25);
    const Outcome missed =
        run("render hole.toml --size 32x16 -o b.exr --quiet --json -D integrator.max_pixel_error=1e-30");
    EXPECT_EQ(missed.status, 4) << missed.err;
    EXPECT_TRUE(json::parse(missed.out)["pixel_error_estimate"].is_null());
    EXPECT_TRUE(exists("b.exr"));
}

// All rays of the picture lie in the shadow of the hole, so that no ray has an error.
TEST_F(MaxPixelError, IsMetIfAllRaysAreCaptured) {
    const Outcome met = run(
        "render hole.toml --size 16x16 -o a.exr --quiet --json -D camera.fov=0.5 -D integrator.max_pixel_error=0.25");
    EXPECT_EQ(met.status, 0) << met.err;
    EXPECT_EQ(json::parse(met.out)["status"]["captured"], 256);
    EXPECT_EQ(json::parse(met.out)["pixel_error_estimate"], 0);
    EXPECT_EQ(
        run("compare hole.toml --size 8x8 --rounds 1 --quiet --strategy packet --equal-error 0.25 -D camera.fov=0.5")
            .status,
        0);
}

// Seen from far away, the rays around the hole are ill-conditioned. Their pixel errors are divided by
// conditioning/1000, and a remark must state this.
TEST_F(MaxPixelError, CausesARemarkOnIllConditionedRays) {
    const auto plan = plan_of_file((directory_ / "hole.toml").string(),
                                   {"camera.position=[0,-1000,0]", "camera.fov=0.06", "film.size=[32,32]",
                                    "integrator.escape_radius=2000", "integrator.max_pixel_error=0.25"});
    *plan = choose_method(*plan);
    ASSERT_TRUE(plan->method_trial && plan->method_trial->bound_met);
    EXPECT_GT(plan->method_trial->estimate, 0);
    EXPECT_GT(plan->method_trial->ill_conditioned_share, 0.5);
    const std::vector<std::string>& remarks = plan->method_trial->remarks;
    ASSERT_FALSE(remarks.empty());
    EXPECT_NE(remarks.back().find("they magnify errors more than 1000 times"), std::string::npos) << remarks.back();
}

// If no error can be measured, the picture is rendered with the method of the scene, and the program prints a warning.
TEST_F(MaxPixelError, IsNotMetWithoutAReference) {
    const Outcome few_steps =
        run("render hole.toml --size 16x16 -o a.exr -D integrator.max_steps=5 -D integrator.max_pixel_error=0.25");
    EXPECT_EQ(few_steps.status, 4) << few_steps.err;
    EXPECT_NE(few_steps.err.find("may not be met"), std::string::npos) << few_steps.err;
    EXPECT_TRUE(exists("a.exr"));
    // Most rays are closed orbits, and a few escape.
    write("circles.toml", R"(
space = { hamiltonian = "fisheye", n0 = 2, radius = 1 }
camera = { position = [-1, 0, 0], look_at = [0, 0, 0], fov = 90 }
film = { size = [8, 8] }
integrator = { escape_radius = 6, max_steps = 2000, max_pixel_error = 0.25 }
)");
    const Outcome circling = run("render circles.toml -o b.exr");
    EXPECT_EQ(circling.status, 4) << circling.err;
    EXPECT_NE(circling.err.find("the trial needs at least"), std::string::npos) << circling.err;
    EXPECT_TRUE(exists("b.exr"));
}

// A time limit cuts the picture short and changes nothing else.
TEST_F(MaxPixelError, DoesNotDependOnTheTimeLimit) {
    const std::string command = "render hole.toml --size 16x16 -o a.exr -D integrator.max_pixel_error=0.25 --json";
    const Outcome limited = run(command + " --time-limit 1e-4"), unlimited = run(command);
    EXPECT_EQ(limited.status, 0) << limited.err;
    EXPECT_TRUE(exists("a.exr"));
    for (const char* key : {"\"integrator\":", "\"step\":", "\"precision\":"}) {
        const auto line = [&](const std::string& report) {
            const std::size_t begin = report.find(key);
            return begin == std::string::npos ? "" : report.substr(begin, report.find('\n', begin) - begin);
        };
        EXPECT_NE(line(unlimited.out), "") << key;
        EXPECT_EQ(line(limited.out), line(unlimited.out)) << key;
    }
}

// The study finds the longest step whose error is within the bound. The error of a step that is longer by a factor of
// 2^(1/16) must exceed the bound.
TEST_F(MaxPixelError, IsMetWithTheLongestSteps) {
    const auto plan = plan_of_file(scene_file("room.toml"), {"film.size=[64, 64]"});
    StudyOptions options;
    options.width = options.height = 16;
    options.quick = true;
    options.pixel_bound = 0.25;
    const ErrorStudy study = study_error(*plan, options);
    std::size_t compared = 0;
    for (const StudyCurve& curve : study.curves) {
        SCOPED_TRACE(curve.method);
        const auto longest = std::find_if(curve.points.begin(), curve.points.end(), [&](const StudyPoint& point) {
            return is_within(point, options.pixel_bound, &RayErrors::pixels, study.reference);
        });
        if (curve.info->adaptive || longest == curve.points.begin() || longest == curve.points.end()) continue;
        EXPECT_LE(std::prev(longest)->step, 1.0001 * std::exp2(1.0 / 16) * longest->step);
        ++compared;
    }
    EXPECT_GE(compared, 3u);
}

TEST_F(MaxPixelError, CostsLessIfItIsLarger) {
    const auto gradients = [&](const char* bound) {
        const Outcome outcome =
            run(std::string("render hole.toml --size 64x32 -o a.exr --quiet --json -D integrator.max_pixel_error=") +
                bound);
        return json::parse(outcome.out)["gradients"].get<double>();
    };
    EXPECT_LT(gradients("1"), gradients("1e-6"));
}

TEST_F(MaxPixelError, KeepsTheRequestedPrecision) {
    for (const char* precision : {"double", "float"}) {
        const Outcome outcome =
            run(std::string("explain hole.toml --json -D integrator.max_pixel_error=0.25 --precision ") + precision);
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_EQ(json::parse(outcome.out)["precision"], precision);
    }
}

TEST_F(MaxPixelError, CausesAMessageOnAStatedStep) {
    const auto messages = [&](const std::string& options) {
        return run("explain hole.toml -D integrator.max_pixel_error=" + options).err;
    };
    EXPECT_NE(messages("0.25 -D integrator.step=0.07").find("integrator.step = 0.07 is not used"), std::string::npos);
    EXPECT_NE(messages("0.25 -D integrator.tolerance=1e-5").find("integrator.tolerance = 1e-05 is not used"),
              std::string::npos);
    EXPECT_EQ(messages("0.25").find("is not used"), std::string::npos);
    EXPECT_EQ(messages("1e-30 -D integrator.step=0.07").find("is not used"), std::string::npos);
}

TEST_F(MaxPixelError, KeepsTheRequestedMethodStrategyAndLanes) {
    for (const char* options :
         {"--integrator gauss8 --lanes 1", "--strategy scalar", "--integrator rk4 --strategy packet"}) {
        SCOPED_TRACE(options);
        const Outcome outcome =
            run(std::string("render hole.toml -o a.exr --quiet --json -D integrator.max_pixel_error=0.25 ") + options);
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        const json report = json::parse(outcome.out);
        EXPECT_LE(report["pixel_error_estimate"], 0.25);
        for (const char* method : {"gauss8", "rk4"})
            if (std::string(options).find(method) != std::string::npos) {
                EXPECT_EQ(report["integrator"], method);
            }
        const bool scalar = std::string(options).find("packet") == std::string::npos;
        EXPECT_EQ(report["strategy"], scalar ? "scalar" : "packet");
    }
}

}  // namespace
}  // namespace kagero::test
