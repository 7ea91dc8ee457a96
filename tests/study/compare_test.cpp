// Tests of `kagero compare`: the pictures of all strategies, forms and packet widths, and the report.
#include "tests/support/hole_scene.h"
#include "tests/support/plan_fixture.h"

#include "study/compare/compare.h"
#include "plan/kernels.h"
#include "report/compare_report.h"

#include <nlohmann/json.hpp>

#include <atomic>
#include <limits>
#include <set>

namespace kagero::test {
namespace {

using nlohmann::json;

SceneDescription small_room(const Overrides& more = {}) {
    Overrides overrides{"film.size=[48,40]"};
    overrides.insert(overrides.end(), more.begin(), more.end());
    return load_scene(KAGERO_SCENES "/room.toml", overrides, catalogue("auto"));
}

/// Returns options for one round on all instruction sets.
CompareOptions one_round(const std::vector<std::string>& methods) {
    CompareOptions options;
    options.isas = supported_isas();
    options.methods = methods;
    options.rounds = 1;
    return options;
}

// Pictures are compared with the picture of the scalar kernel in double. Scalar and packet code have the same
// roundings, so that their pictures must be equal. Kernels of the form `gradient` sum the gradient in a different
// order, and kernels in float have larger errors. With these kernels, status or object may differ for at most 1 % of
// the pixels.
TEST(Compare, RendersTheSamePictureWithEveryKernel) {
    const Comparison result = compare(small_room(), one_round({"gauss8", "verlet"}));
    const std::uint64_t pixels = 48 * 40;
    bool is_form_compared[5] = {};
    for (const CompareRow& row : result.rows) {
        const KernelInfo& kernel = *row.kernel;
        SCOPED_TRACE(row.isa + " " + name_of(kernel.strategy) + " " + name_of(kernel.form) + " " + row.method + " " +
                     name_of(kernel.precision) + " " + std::to_string(kernel.lanes) + " " + row.shape);
        is_form_compared[static_cast<int>(kernel.form)] = true;
        EXPECT_GT(row.seconds.median, 0);
        EXPECT_GT(row.speedup, 0);
        const bool exact = kernel.precision == Precision::float64 && kernel.form != Form::gradient;
        EXPECT_LE(row.flips, exact ? 0 : pixels / 100);
        if (exact) {
            EXPECT_EQ(row.max_difference, 0);
        }
    }
    for (const bool is_compared : is_form_compared) EXPECT_TRUE(is_compared);
    EXPECT_EQ(result.rays, pixels);
}

/// Traces the rays of the room with every kernel in double. Expects that all kernels return the ray ends of the scalar
/// kernel, and that the set of their forms is `forms`.
void expect_same_ends(const char* override_text, const std::set<Form>& forms) {
    SCOPED_TRACE(override_text);
    const auto plan =
        plan_of_file(KAGERO_SCENES "/room.toml", {"film.size=[48,40]", override_text}, with_strategy("scalar"));
    std::set<Form> tested;
    std::vector<RayStart> starts;
    for (std::uint32_t y = 0; y < 40; ++y)
        for (std::uint32_t x = 0; x < 48; ++x) starts.push_back(pixel_ray_start(*plan, x, y));
    std::vector<RayEnd> expected;
    trace(*plan, starts, expected);
    for (std::uint32_t k = 0; k < plan->module().kernel_count; ++k) {
        const KernelInfo& kernel = plan->module().kernels[k];
        if (kernel.precision != Precision::float64 || refusal_of(*plan->scene, kernel, plan->run.method))
            continue;
        plan->run.kernel = &kernel;
        tested.insert(kernel.form);
        std::vector<RayEnd> ends;
        trace(*plan, starts, ends);
        // Kernels of these forms sum the gradient or the stages in a different order. The tolerance covers the growth
        // of rounding errors along the rays.
        const double tolerance = kernel.form == Form::gradient || kernel.form == Form::stages ? 1e-7 : 0;
        for (std::size_t i = 0; i < ends.size(); ++i) {
            ASSERT_EQ(ends[i].status, expected[i].status) << k << " " << i;
            for (int c = 0; c < 3; ++c) ASSERT_NEAR(ends[i].q[c], expected[i].q[c], tolerance) << k << " " << i;
        }
    }
    EXPECT_EQ(tested, forms);
}

TEST(Compare, TracesTheSameRayEndsWithEveryKernel) {
    expect_same_ends("integrator.symmetry=auto", {Form::none, Form::gradient, Form::auto_vectorized, Form::gang});
    expect_same_ends("integrator.symmetry=none", {Form::none, Form::gradient, Form::auto_vectorized, Form::gang});
    expect_same_ends("integrator.method=gauss8",
                     {Form::none, Form::gradient, Form::stages, Form::auto_vectorized, Form::gang});
}

// A kernel of the form `stages` computes each stage of a collocation method in a lane of its own.
TEST(Compare, HasKernelsWithStagesInLanesForCollocationMethods) {
    const auto form = [](const char* method) {
        return plan_of_file(KAGERO_SCENES "/room.toml", {std::string("integrator.method=") + method},
                            with_strategy("per-ray"))
            ->run.kernel->form;
    };
    EXPECT_EQ(form("gauss8"), Form::stages);
    EXPECT_EQ(form("gauss16"), Form::stages);
    EXPECT_EQ(form("verlet"), Form::gradient);
}

// After an interruption, the differences of kernels that rendered no picture must be null.
TEST(Compare, ReportsNoDifferencesOfPicturesThatWereNotRendered) {
    std::atomic<bool> stop = false;
    CompareOptions options = one_round({"verlet"});
    options.isas.resize(1);
    int progress_reports = 0;
    const SceneDescription scene = small_room();
    const Comparison result = compare(scene, options, [&](double, double) { stop = ++progress_reports == 2; }, &stop);
    EXPECT_TRUE(result.interrupted);
    ASSERT_GT(result.rows.size(), 3u);
    const json rows = json::parse(compare_json(scene, options, result))["rows"];
    EXPECT_TRUE(result.rows[1].rendered);
    EXPECT_TRUE(rows[1]["flips"].is_number());
    EXPECT_FALSE(result.rows.back().rendered);
    EXPECT_TRUE(rows.back()["flips"].is_null());
    EXPECT_TRUE(rows.back()["max_difference"].is_null());
}

class CompareVerb : public HoleTest {};

TEST_F(CompareVerb, ReportsAllKeys) {
    const Outcome outcome = run("compare hole.toml --rounds 1 --json --quiet");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const json report = json::parse(outcome.out);
    ASSERT_FALSE(report["rows"].empty());
    for (const json& row : report["rows"]) {
        for (const char* key :
             {"strategy", "form", "method", "precision", "isa", "lanes", "registers", "shape", "threads", "seconds",
              "mrays_per_s", "speedup", "lane_occupancy", "max_difference", "flips"})
            EXPECT_TRUE(row.contains(key)) << key;
        for (const char* key : {"median", "min", "max"}) EXPECT_TRUE(row["seconds"][key].is_number()) << key;
        EXPECT_EQ(row["threads"], 1);
        const bool is_baseline = row["strategy"] == "scalar" && row["precision"] == "double" && row["form"].is_null();
        if (is_baseline) {
            EXPECT_EQ(row["speedup"], 1);
        }
    }
}

TEST_F(CompareVerb, ComparesOnlyTheRequestedKernels) {
    const Outcome per_ray = run("compare hole.toml --rounds 1 --strategy per-ray --json --quiet");
    ASSERT_EQ(per_ray.status, 0) << per_ray.err;
    const json report = json::parse(per_ray.out);
    for (const json& row : report["rows"])
        EXPECT_TRUE(row["strategy"] == "per-ray" || row["speedup"] == 1) << row;
    const Outcome seven_lanes = run("compare hole.toml --lanes 7");
    EXPECT_EQ(seven_lanes.status, 2);
    EXPECT_NE(seven_lanes.err.find("no kernel has 7 lanes; kernels exist with these numbers of lanes: 1, "),
              std::string::npos)
        << seven_lanes.err;
    const Outcome none = run("compare hole.toml --strategy per-ray --precision float");
    EXPECT_EQ(none.status, 2);
    EXPECT_NE(none.err.find("strategy per-ray, float: no kernel has these properties"), std::string::npos) << none.err;
    EXPECT_EQ(run("compare hole.toml --methods gauss7").status, 2);
    EXPECT_EQ(run("compare hole.toml --equal-error 0").status, 2);
    const Outcome table = run("compare hole.toml --rounds 1 --lanes 1");
    EXPECT_EQ(table.status, 0) << table.err;
    EXPECT_NE(table.out.find("speedup"), std::string::npos) << table.out;
}

// With --baseline, speeds and pictures of all rows are compared with one row, scalar double of that instruction set. It
// is measured even if --isa does not contain the instruction set. Instruction sets round elementary functions
// differently, which moves the ends of single rays.
TEST_F(CompareVerb, ComparesAllRowsWithTheBaselineOfOneInstructionSet) {
    const std::string baseline = supported_isas().back(), other = supported_isas().front();
    const Outcome outcome = run("compare hole.toml --rounds 2 --strategy packet --precision double --json --quiet " +
                                ("--isa " + other + " --baseline " + baseline));
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const json report = json::parse(outcome.out);
    const json& rows = report["rows"];
    const json& first = rows[0];
    EXPECT_EQ(first["isa"], baseline);
    EXPECT_EQ(first["strategy"], "scalar");
    EXPECT_EQ(report["baseline"], baseline);
    for (const char* key : {"version", "processor", "compiler"}) EXPECT_TRUE(report[key].is_string()) << key;
    for (const std::string& isa : {baseline, other}) EXPECT_TRUE(report["flags"][isa].is_string()) << isa;
    ASSERT_GT(rows.size(), 1u);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        SCOPED_TRACE(i);
        const json &samples = rows[i]["seconds"]["samples"], &expected = first["seconds"]["samples"];
        ASSERT_EQ(samples.size(), 2u);
        const auto ratio = [&](std::size_t k) { return expected[k].get<double>() / samples[k].get<double>(); };
        EXPECT_NEAR(rows[i]["speedup"].get<double>(), 0.5 * (ratio(0) + ratio(1)), 1e-12 * (ratio(0) + ratio(1)));
        EXPECT_LE(rows[i]["flips"], 2);
        if (i > 0) {
            EXPECT_EQ(rows[i]["isa"], other);
            EXPECT_EQ(rows[i]["strategy"], "packet");
        }
    }
    const Outcome unknown = run("compare hole.toml --baseline mmx");
    EXPECT_EQ(unknown.status, 2);
    EXPECT_NE(unknown.err.find("--baseline"), std::string::npos) << unknown.err;
}

// The default method of the mirage supports only the rescaled H.
TEST_F(CompareVerb, UsesADefaultMethodThatNeedsTheRescaling) {
    write("mirage.toml",
          "[space]\nhamiltonian = \"mirage\"\n[camera]\nposition = [0, -3, 0.2]\nlook_at = [0, 0, 0.2]\nup = [0, 0, "
          "1]\n[film]\nsize = [8, 8]\n");
    const Outcome outcome = run("compare mirage.toml --rounds 1 --strategy scalar --quiet");
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("srkn6"), std::string::npos) << outcome.out;
}

TEST_F(CompareVerb, ReportsKeysWithoutEffect) {
    for (const std::string key : {"integrator.max_pixel_error", "integrator.tolerance"}) {
        const Outcome outcome =
            run("compare hole.toml --rounds 1 --lanes 1 --strategy scalar --integrator rk4 -D " + key + "=0.1");
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_NE(outcome.err.find(key + " has no effect"), std::string::npos) << outcome.err;
    }
}

TEST_F(CompareVerb, ComparesAtEqualErrors) {
    const Outcome outcome = run("compare hole.toml --rounds 1 --equal-error 0.25 --precision double --json --quiet");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const json report = json::parse(outcome.out);
    EXPECT_EQ(report["equal_error"], 0.25);
    EXPECT_GT(report["rows"].size(), 2u);
}

// The lanes are those of one packet, or of all packets of a gang. Pictures must not depend on the number of lanes.
TEST_F(CompareVerb, HasKernelsWith16To256Lanes) {
    write(
        "mirage.toml",
        "[space]\nhamiltonian = \"mirage\"\n[camera]\nposition = [0, -3, 0.2]\nlook_at = [0, 0, 0.2]\nup = [0, 0, 1]\n"
        "[film]\nsize = [24, 20]\n[sky]\nchecker = true\n");
    ASSERT_EQ(run("render mirage.toml -o default.pfm --quiet --precision double").status, 0);
    const std::string expected = read("default.pfm");
    for (const char* lanes : {"16", "32", "64", "128", "256"}) {
        const Outcome outcome =
            run(std::string("render mirage.toml -o lanes.pfm --quiet --precision double --json --lanes ") + lanes);
        ASSERT_EQ(outcome.status, 0) << lanes << ": " << outcome.err;
        EXPECT_EQ(json::parse(outcome.out)["lanes"], std::stoi(lanes));
        EXPECT_EQ(read("lanes.pfm"), expected) << lanes;
    }
}

TEST_F(CompareVerb, RefusesNumbersOfLanesWithoutAKernel) {
    EXPECT_EQ(run("render hole.toml -o a.png --quiet --lanes 1").status, 0);
    EXPECT_EQ(run("render hole.toml -o a.png --quiet --lanes 128").status, 0);
    const auto lanes = [&](const char* options) {
        return json::parse(run(std::string("explain hole.toml --json ") + options).out)["lanes"];
    };
    EXPECT_EQ(lanes("-D integrator.lanes=1 --lanes auto"), lanes(""));
    EXPECT_EQ(lanes("-D integrator.lanes=1"), 1);
    const Outcome none = run("render hole.toml -o a.png --quiet --lanes 7");
    EXPECT_EQ(none.status, 2);
    EXPECT_NE(none.err.find("available numbers of lanes: 1, "), std::string::npos) << none.err;
    const Outcome per_ray_formula =
        run("render hole.toml -o a.png --quiet --strategy per-ray -D space.hamiltonian=formula -D 'space.H=\"px\"'");
    EXPECT_EQ(per_ray_formula.status, 2) << per_ray_formula.err;
}

}  // namespace
}  // namespace kagero::test
