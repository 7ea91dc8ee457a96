// Tests of `kagero stability`: the list of cases, their results, and the reports.
#include "stability/stability.h"
#include "tests/support/plan_fixture.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <atomic>
#include <set>

namespace kagero::test {
namespace {

using nlohmann::json;

class Stability : public ProgramTest {};

TEST(StabilityCases, HaveUniqueNamesAndAreComplete) {
    const auto names = stability_case_names();
    EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
    for (const char* name : {"layer-refraction", "layer-momentum", "lens-surface",
                             "photon-sphere",    "near-critical",  "near-horizon",
                             "inside",           "captured-stay",  "wrong-time-momentum",
                             "unsolvable-step",  "coarse-steps",   "vanishing-index",
                             "long-path",        "scaled-scene",   "unusable-input",
                             "denormals",        "grazing",        "trapped",
                             "throat",           "float-floor",    "straight-picture"})
        EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
}

TEST_F(Stability, ReportsEachCaseInJson) {
    const Outcome outcome = run("stability layer-momentum throat --json");
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const json report = json::parse(outcome.out);
    ASSERT_EQ(report["cases"].size(), 2u);
    for (const json& row : report["cases"]) {
        for (const char* key : {"name", "what", "expected", "got"})
            EXPECT_FALSE(row.at(key).get<std::string>().empty()) << key;
        EXPECT_TRUE(row.at("pass").get<bool>()) << row;
    }
    EXPECT_EQ(report["cases"][0]["name"], "layer-momentum");
    EXPECT_EQ(report["cases"][1]["name"], "throat");
}

// The exit status must be 0 if all cases pass, otherwise 4.
TEST_F(Stability, RunsEveryCase) {
    const Outcome outcome = run("stability --json report.json -o page --quiet");
    const json report = json::parse(read("report.json"));
    EXPECT_EQ(report["cases"].size(), stability_case_names().size());
    const bool all_pass = std::all_of(report["cases"].begin(), report["cases"].end(),
                                      [](const json& row) { return row["pass"].get<bool>(); });
    EXPECT_EQ(outcome.status, all_pass ? 0 : 4) << outcome.err;
    EXPECT_EQ(json::parse(read("page/stability.json")), report);
    const std::string page = read("page/stability.html");
    for (const std::string& name : stability_case_names()) {
        EXPECT_NE(page.find(">" + name + "</td>"), std::string::npos) << name;
        EXPECT_NE(outcome.out.find(name), std::string::npos) << name;
    }
    EXPECT_EQ(page.find("http"), std::string::npos) << "the page must not refer to other files";
    for (const json& row : report["cases"]) EXPECT_TRUE(row["pass"].get<bool>()) << row;
}

TEST_F(Stability, RunsInOnePrecisionAndStrategy) {
    const Outcome outcome = run("stability trapped --precision double --strategy scalar --json out.json");
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("pass  trapped"), std::string::npos);
}

// The report must have a column for each instruction set that was built and that this machine supports.
TEST_F(Stability, RunsOnSeveralInstructionSets) {
    const auto isas = supported_isas();
    const Outcome outcome = run("stability trapped --isa all --json out.json -o page");
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const json row = json::parse(read("out.json"))["cases"][0];
    const std::string page = read("page/stability.html");
    ASSERT_EQ(row["isas"].size(), isas.size());
    for (std::size_t i = 0; i < isas.size(); ++i) {
        EXPECT_EQ(row["isas"][i]["isa"], isas[i]);
        EXPECT_TRUE(row["isas"][i]["pass"].get<bool>());
        EXPECT_NE(page.find(">" + isas[i] + "</th>"), std::string::npos) << isas[i];
    }
    EXPECT_EQ(json::parse(run("stability trapped --isa " + isas[0] + "," + isas[0] + " --json").out)["cases"][0]["isas"]
                  .size(),
              1u);
    EXPECT_EQ(run("stability trapped --isa mmx").status, 2);
}

TEST(StabilityCases, AreNotRunAfterAnInterruption) {
    std::atomic<bool> stop = false;
    const auto rows = run_stability(
        {"inside", "trapped"}, {.precisions = {Precision::float64}}, [&](const StabilityRow&) { stop = true; }, &stop);
    ASSERT_EQ(rows.size(), 1u);
    EXPECT_EQ(rows[0].name, "inside");
    EXPECT_FALSE(rows[0].outcomes.empty());
}

TEST_F(Stability, RefusesAStrategyWithoutCases) {
    const Outcome outcome = run("stability trapped --strategy per-ray");
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find("--strategy"), std::string::npos) << outcome.err;
}

TEST_F(Stability, SuggestsTheNameOfAMisspeltCase) {
    const Outcome outcome = run("stability photon-spere");
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find("photon-sphere"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace kagero::test
