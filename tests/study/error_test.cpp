// Tests of `kagero error`: completeness of the report, and measured orders and errors against the theory.
#include "tests/support/hole_scene.h"
#include "modules/modules.h"
#include "accuracy/ray_errors.h"
#include "accuracy/step_ladder.h"
#include "report/text/numbers.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace kagero::test {
namespace {

using nlohmann::json;

constexpr const char* command = "error hole.toml --quick --sample 8x8 --quiet -D integrator.escape_radius=4";

class Error : public HoleTest {
protected:
    json study(const std::string& more = "") {
        const Outcome outcome = run(command + std::string(" --json ") + more);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_EQ(outcome.err, "");
        return json::parse(outcome.out);
    }
    static json curve_of(const json& study, const std::string& method) {
        for (const json& curve : study["curves"])
            if (curve["method"] == method && curve["strategy"] == "packet" && curve["precision"] == "double")
                return curve;
        ADD_FAILURE() << "no curve of " << method;
        return {};
    }
};

/// Returns a study without its run times, which differ between two runs.
json without_times(json study) {
    study.erase("seconds");
    study.erase("cheapest");
    for (json& picture : study["pictures"]) picture.erase("seconds");
    for (json& strategy : study["strategies"]) strategy.erase("ns_per_ray");
    for (json& curve : study["curves"])
        for (json& point : curve["points"]) {
            point.erase("ns_per_ray");
            point.erase("ns_per_ray_without_surfaces");
        }
    return study;
}

void expect_ascending(const json& percentiles) {
    EXPECT_LE(percentiles["p50"], percentiles["p90"]);
    EXPECT_LE(percentiles["p90"], percentiles["p99"]);
    EXPECT_LE(percentiles["p99"], percentiles["max"]);
}

TEST_F(Error, WritesACompleteReport) {
    const json report = study("-o report");
    EXPECT_EQ(report, json::parse(read("report/results.json")));
    for (const char* key : {"reference", "curves", "cheapest", "sample", "isa", "machine", "compiler"})
        EXPECT_TRUE(report.contains(key)) << key;
    std::size_t points = 0;
    for (const json& curve : report["curves"]) {
        for (const char* key : {"method", "strategy", "precision", "order", "points"})
            EXPECT_TRUE(curve.contains(key)) << key;
        points += curve["points"].size();
        for (const json& point : curve["points"]) {
            for (const char* key : {"step", "ns_per_ray", "gradients_per_ray", "steps_per_ray", "position", "direction",
                                    "pixels", "flips", "energy_drift"})
                EXPECT_TRUE(point.contains(key)) << key;
            for (const char* key : {"position", "direction", "pixels"}) expect_ascending(point[key]);
            for (const char* key : {"max", "first_tenth", "last_tenth"})
                EXPECT_TRUE(point["energy_drift"].contains(key)) << key;
            EXPECT_LE(point["ns_per_ray"]["min"], point["ns_per_ray"]["median"]);
            EXPECT_LE(point["ns_per_ray"]["median"], point["ns_per_ray"]["max"]);
        }
    }
    for (const json& best : report["cheapest"])
        for (const char* key : {"error", "method", "step", "precision", "ns_per_ray"})
            EXPECT_TRUE(best.contains(key)) << key;
    EXPECT_EQ(lines_of(read("report/results.csv")).size(), points + 1);
    const std::string page = read("report/report.html");
    EXPECT_TRUE(page.starts_with("<!doctype html>") && page.ends_with("</html>\n"));
    EXPECT_EQ(page.find("<script"), std::string::npos);
    EXPECT_EQ(page.find(" src="), std::string::npos);
    // The page contains the picture and its two error maps.
    EXPECT_NE(page.find("Error map of the picture"), std::string::npos);
    std::size_t pictures = 0;
    for (std::size_t at = page.find("data:image/png;base64,iVBOR"); at != std::string::npos;
         at = page.find("data:image/png;base64,iVBOR", at + 1))
        ++pictures;
    EXPECT_EQ(pictures, 4u);  // including the colour scale
    EXPECT_NE(read("report/plot.gp").find("results.csv"), std::string::npos);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(directory_ / "report"), {}), 4);
}

// The report must contain both strategies in both precisions for each instruction set that this machine supports.
TEST_F(Error, TimesStrategiesOnEveryInstructionSet) {
    const json report = study();
    std::size_t isas = 0;
    for (const IsaInfo& isa : find_isas()) {
        if (!isa.supported) continue;
        ++isas;
        for (const char* strategy : {"scalar", "packet"})
            for (const char* precision : {"double", "float"})
                EXPECT_EQ(std::count_if(report["strategies"].begin(), report["strategies"].end(),
                                        [&](const json& row) {
                                            return row["isa"] == isa.name && row["strategy"] == strategy &&
                                                   row["form"].is_null() && row["precision"] == precision &&
                                                   row["ns_per_ray"]["min"] > 0;
                                        }),
                          1)
                    << isa.name << " " << strategy << " " << precision;
    }
    const json alone = study("--isa " + report["isa"].get<std::string>());
    for (const json& row : alone["strategies"]) EXPECT_EQ(row["isa"], report["isa"]);
    EXPECT_GE(report["strategies"].size(), 4 * isas);
}

TEST_F(Error, MeasuresTheOrdersOfTheMethods) {
    const json report = study();
    EXPECT_LT(report["reference"]["uncertainty"]["p99"], 1e-11);
    EXPECT_NEAR(curve_of(report, "verlet")["order"].get<double>(), 2, 0.3);
    EXPECT_NEAR(curve_of(report, "satoh2")["order"].get<double>(), 1, 0.3);
    EXPECT_NEAR(curve_of(report, "rk4")["order"].get<double>(), 4, 0.6);
    const json gauss = curve_of(report, "gauss8")["points"];
    ASSERT_GE(gauss.size(), 5u);
    // The coarsest steps exceed the step bound of the space near the hole, so that the error can be the same.
    for (std::size_t i = 1; i < 4; ++i) EXPECT_LE(gauss[i]["position"]["p90"], gauss[i - 1]["position"]["p90"]);
    EXPECT_LT(gauss[3]["position"]["p90"], gauss[0]["position"]["p90"]);
    EXPECT_TRUE(curve_of(report, "dp54")["order"].is_null());
    EXPECT_TRUE(exists("hole-error/report.html"));
}

// All lengths of the scene are multiplied by 2e9. The measured orders must not change.
TEST_F(Error, DoesNotDependOnTheUnitOfLength) {
    const json small = study(),
               large = study("-D space.rg=2e8 -D camera.position=[0,-4e9,0] -D integrator.escape_radius=8e9");
    EXPECT_EQ(small["reference"]["method"], large["reference"]["method"]);
    for (const char* method : {"verlet", "rk4", "gauss8"})
        EXPECT_NEAR(curve_of(small, method)["order"].get<double>(), curve_of(large, method)["order"].get<double>(),
                    0.01)
            << method;
}

// A ray whose status or object differs from the reference has no position error. The ray is counted as a flip, and the
// percentiles do not include it.
TEST_F(Error, CountsFlipsSeparately) {
    const json report = study("--integrator gauss8 --step 0.5");
    const std::uint64_t decided = report["reference"]["decided"], captured = report["reference"]["status"]["captured"];
    std::uint64_t flips = 0;
    for (const json& curve : report["curves"])
        for (const json& point : curve["points"]) {
            const std::uint64_t point_flips = point["flips"], compared = point["compared"],
                                ill_conditioned_rays = point["ill_conditioned"]["rays"];
            EXPECT_LE(compared + ill_conditioned_rays + point_flips, decided);
            EXPECT_GE(compared + ill_conditioned_rays + point_flips + captured, decided);
            flips += point_flips;
        }
    EXPECT_GT(flips, 0u) << "the coarsest steps should change the status of some rays";
}

// Only collocation methods support the discontinuity of the lens. The reference is confirmed by a second collocation
// method.
TEST_F(Error, ConfirmsTheReferenceOfALensByASecondCollocationMethod) {
    const Outcome outcome =
        run("error " KAGERO_SCENES "/luneburg.toml --quick --sample 12x12 -o lens --json lens.json --quiet");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const json report = json::parse(read("lens.json"));
    EXPECT_EQ(report["reference"]["confirmed_by"], "gauss12");
    EXPECT_LT(report["reference"]["uncertainty"]["p90"], 1e-10);
    EXPECT_GT(report["reference"]["decided"], 100);
}

// Every step ladder has at least five steps, also for an expensive method. The additional ladders, with a loose solver
// tolerance or with the strategy `scalar`, have at least three. The ladders of methods that do not support the rescaled
// H begin with longer steps.
TEST_F(Error, MeasuresEveryMethodWithAtLeastFiveSteps) {
    const Outcome outcome =
        run("error " KAGERO_SCENES
            "/kerr.toml --quick --sample 4x4 -D integrator.symmetry=none -o spin --json spin.json --quiet");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const json report = json::parse(read("spin.json"));
    for (const json& curve : report["curves"]) {
        const bool additional = curve["loose"] || curve["strategy"] == "scalar";
        EXPECT_GE(curve["points"].size(), additional ? 3u : 5u) << curve["method"] << curve["strategy"];
    }
    EXPECT_EQ(curve_of(report, "satoh4")["points"][0]["step"],
              2 * curve_of(report, "verlet")["points"][0]["step"].get<double>());
}

TEST_F(Error, IsDeterministicExceptForRunTimes) {
    EXPECT_EQ(without_times(study()), without_times(study()));
}

TEST_F(Error, IsZeroForStraightRays) {
    const json report = study("-D space.rg=0");
    EXPECT_TRUE(report["straight"].get<bool>());
    ASSERT_FALSE(report["curves"].empty());
    EXPECT_LT(report["curves"][0]["points"][0]["position"]["max"], 1e-12);
}

TEST(LadderFit, IgnoresUnknownErrors) {
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    const LadderFit second = fit_ladder({8, 4, 2, 1}, {unknown, 0.16, 0.04, 0.01}, 2, 10);
    ASSERT_TRUE(second.order && second.floor);
    EXPECT_NEAR(*second.order, 2, 1e-12);
    EXPECT_EQ(*second.floor, 0.01);
    const LadderFit none = fit_ladder({2, 1}, {unknown, unknown}, 2, 10);
    EXPECT_FALSE(none.order || none.floor);
    EXPECT_TRUE(std::isnan(percentiles_of({}).p50));
}

TEST(Percentiles, AreBoundsForTheStatedShareOfTheValues) {
    std::vector<double> values;
    for (int i = 1; i <= 100; ++i) values.push_back(i);
    const Percentiles hundred = percentiles_of(values);
    EXPECT_EQ(hundred.p50, 50);
    EXPECT_EQ(hundred.p90, 90);
    EXPECT_EQ(hundred.p99, 99);
    values.resize(64);
    EXPECT_EQ(percentiles_of(values).p99, 64) << "63 of 64 are less than 99 %";
    EXPECT_EQ(percentiles_of({7}).p50, 7);
}

// A bin of the histogram has a relative width of 1/256. The percentiles of the histogram are compared with those of the
// sorted values.
TEST(PercentileHistogram, CountsWithARelativeErrorOfAtMostOne256th) {
    PercentileHistogram histogram, other_half;
    EXPECT_TRUE(std::isnan(histogram.percentiles().p50)) << "without values";
    std::vector<double> values;
    for (int i = 0; i < 3001; ++i) values.push_back(std::exp(0.05 * (i % 1000) - 37 + 1e-4 * i));
    values.insert(values.end(), {0, 1e-300, 1e40});
    for (std::size_t i = 0; i < values.size(); ++i) (i % 2 ? histogram : other_half).add(values[i]);
    histogram.add(other_half);
    const Percentiles found = histogram.percentiles(), expected = percentiles_of(values);
    for (const auto share : {&Percentiles::p50, &Percentiles::p90, &Percentiles::p99}) {
        EXPECT_GE(found.*share, expected.*share);
        EXPECT_LE(found.*share, expected.*share * (1 + 1 / 256.0));
    }
    EXPECT_EQ(found.max, 1e40);
    PercentileHistogram equal;
    for (int i = 0; i < 3; ++i) equal.add(7);
    EXPECT_EQ(equal.percentiles().p50, 7) << "at most the greatest value";
}

TEST(Numbers, AreRoundedBeforeTheirUnitPrefixIsChosen) {
    EXPECT_EQ(rounded(999.4), "999");
    EXPECT_EQ(rounded(999.6), "1 k");
    EXPECT_EQ(rounded(999600), "1 M");
    EXPECT_EQ(rounded(-1234), "-1.23 k");
}

// The report must contain charts and pictures also without the strategy `packet` or without double precision.
TEST_F(Error, ShowsTheRequestedStrategyAndPrecision) {
    for (const std::string options : {"--strategy scalar", "--precision float"}) {
        const json report = study(options + " -o " + options.substr(2, 5));
        EXPECT_GE(report["pictures"].size(), 1u) << options;
        const std::string directory = options.substr(2, 5) + "/", page = read(directory + "report.html"),
                          script = read(directory + "plot.gp");
        EXPECT_NE(script.find("plot \\\n    'results.csv'"), std::string::npos) << script;
        EXPECT_NE(script.find(options == "--strategy scalar" ? "eq 'scalar'" : "eq 'packet'"), std::string::npos)
            << script;
        const std::size_t chart = page.find("Error against run time"), next = page.find("Error against work");
        EXPECT_LT(page.find("<path", chart), next) << options << ": the chart has no curves";
        EXPECT_EQ(page.find("nan"), std::string::npos) << options;
    }
}

TEST_F(Error, RefusesWrongInput) {
    EXPECT_EQ(run("error").status, 2);
    EXPECT_EQ(run("error hole.toml --sample 8").status, 2);
    EXPECT_EQ(run("error hole.toml --sample 0x8").status, 2);
    EXPECT_EQ(run("error hole.toml --quick --full").status, 2);
    write("file", "");
    EXPECT_EQ(run("error hole.toml --quick -o file").status, 2);
    EXPECT_EQ(run("error hole.toml -o missing --sample huge").status, 2);
    EXPECT_FALSE(exists("missing"));
}

}  // namespace
}  // namespace kagero::test
