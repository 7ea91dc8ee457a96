// Tests of the warnings about untrustworthy results: alike in every verb, on stderr and in JSON, and none without
// cause.
#include "tests/support/hole_scene.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

namespace kagero::test {
namespace {

using nlohmann::json;

class Warnings : public HoleTest {
protected:
    /// Returns the keys of the warnings in the JSON report of a command.
    std::vector<std::string> keys_of(const std::string& command) const {
        std::vector<std::string> keys;
        const json report = json::parse(run(command + " --quiet --json").out);
        for (const json& warning : report["warnings"]) keys.push_back(warning["key"]);
        return keys;
    }
};

using Keys = std::vector<std::string>;

TEST_F(Warnings, ReportRaysThatReachTheStepLimitInEveryVerb) {
    write("rays.csv", "x,y,z,dx,dy,dz\n0,-10,0,0,1,0.5\n");
    const std::string few_steps = " --integrator dp5 --step 0.25 -D integrator.max_steps=3";
    for (const std::string command :
         {"render hole.toml -o a.png", "trace hole.toml --rays rays.csv", "check hole.toml"}) {
        SCOPED_TRACE(command);
        EXPECT_EQ(keys_of(command + few_steps), Keys{"step_limit"});
        const Outcome outcome = run(command + few_steps);
        EXPECT_EQ(outcome.status, 0);
        EXPECT_NE(outcome.err.find("integrator.max_steps = 3"), std::string::npos) << outcome.err;
    }
}

// The messages about the trial that chooses the method, which are printed before rendering, are also in the JSON.
TEST_F(Warnings, ReportWhatTheTrialPrints) {
    const struct {
        const char* options;
        const char* part;
    } cases[] = {
        {"-D integrator.max_pixel_error=1e-13", "may not be met"},
        {"-D integrator.max_pixel_error=0.5 --step 0.1 --integrator gauss8", "integrator.step = 0.1 is not used"},
    };
    for (const auto& [options, part] : cases)
        for (const std::string verb :
             {"render hole.toml -o a.png ", "explain hole.toml ", "profile hole.toml --repeat 1 "}) {
            SCOPED_TRACE(verb + options);
            EXPECT_EQ(keys_of(verb + options), Keys{"max_pixel_error"});
            const Outcome outcome = run(verb + options + " --json");
            const std::string text = json::parse(outcome.out)["warnings"].at(0)["text"];
            EXPECT_NE(text.find(part), std::string::npos) << text;
            EXPECT_NE(outcome.err.find("warning: " + text), std::string::npos) << outcome.err;
            EXPECT_EQ(outcome.err.find(text, outcome.err.find(text) + 1), std::string::npos) << outcome.err;
        }
}

// Remarks on settings are in every JSON report, and are printed.
TEST_F(Warnings, RemarksAreInEveryReport) {
    write("rays.csv", "x,y,z,dx,dy,dz\n0,-10,0,0,1,0.5\n");
    const std::string options = " --integrator rk4 --step 0.25 --tolerance 1e-6 --threads 1 --json";
    for (const std::string verb :
         {"render hole.toml -o a.png", "trace hole.toml --rays rays.csv", "check hole.toml", "explain hole.toml",
          "profile hole.toml --repeat 1", "compare hole.toml --rounds 1", "error hole.toml --quick --sample 4x4"}) {
        SCOPED_TRACE(verb);
        const Outcome outcome = run(verb + options);
        const json remarks = json::parse(outcome.out)["remarks"];
        ASSERT_EQ(remarks.size(), 1u) << remarks;
        EXPECT_NE(outcome.err.find(std::string(remarks[0])), std::string::npos) << outcome.err;
    }
}

// A single ray of 4096 is reported.
TEST_F(Warnings, ReportASingleRay) {
    const json report =
        json::parse(run("render hole.toml --size 64x64 --integrator dp5 --step 0.25 --quiet --json -o a.png "
                        "-D integrator.max_steps=1000").out);
    ASSERT_EQ(report["status"]["step_limit"], 0);
    EXPECT_EQ(report["warnings"].size(), 0u);
    // The greatest limit that cuts off rays. It cuts off less than 1 % of them.
    const auto limited_report = [&](int limit) {
        return json::parse(run("render hole.toml --size 64x64 --integrator dp5 --step 0.25 --quiet --json -o a.png "
                               "-D integrator.max_steps=" + std::to_string(limit)).out);
    };
    int limit = 10, sufficient = 1000;
    while (sufficient - limit > 5) {
        const int middle = (limit + sufficient) / 2;
        (limited_report(middle)["status"]["step_limit"] > 0 ? limit : sufficient) = middle;
    }
    const json limited = limited_report(limit);
    EXPECT_GT(limited["status"]["step_limit"], 0);
    EXPECT_LT(limited["status"]["step_limit"], 41);
    EXPECT_EQ(limited["warnings"].size(), 1u);
}

// The index changes within a tenth of a unit at r = 1, and steps of a fixed length are too long for it.
TEST_F(Warnings, ReportThatHIsNotConserved) {
    write("lens.toml",
          "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - n^2)\"\n[space.let]\n"
          "r = \"sqrt(x^2 + y^2 + z^2)\"\nn = \"1 + 0.3*exp(-((r - 1)/0.1)^2)\"\n"
          "[integrator]\nescape_radius = 10\n[camera]\nposition = [-5, 0.9, 0]\nlook_at = [0, 0.9, 0]\nup = [0, 0, 1]\n"
          "fov = 3\n[film]\nsize = [16, 12]\n");
    write("rays.csv", "x,y,z,dx,dy,dz\n-5,0.9,0,1,0,0\n-5,0.99,0,1,0,0\n");
    const std::string fixed = " --integrator gauss8 --step 0.3";
    for (const std::string command :
         {"render lens.toml -o a.png", "check lens.toml", "trace lens.toml --rays rays.csv"}) {
        SCOPED_TRACE(command);
        EXPECT_NE(run(command + fixed).err.find("H is not conserved"), std::string::npos);
        EXPECT_EQ(run(command).err.find("H is not conserved"), std::string::npos);
    }
}

// The ingoing Kerr–Schild form is singular for rays that run backward in time. They approach the horizon forever. The
// form with the opposite sign of the null vector is regular.
TEST_F(Warnings, ReportRaysThatApproachAHorizonForever) {
    const auto scene = [](const char* null_vector, const std::string& integrator) {
        return "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - pt^2) - 0.5/r*(pt " +
               std::string(null_vector) + " (x*px + y*py + z*pz)/r)^2\"\ncapture = \"r - 1\"\n[space.constants]\n"
               "pt = 1\n[space.let]\nr = \"sqrt(x^2 + y^2 + z^2)\"\n[integrator]\nescape_radius = 50\n" + integrator +
               "[camera]\nposition = [0, -20, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [16, 12]\n";
    };
    write("rays.csv", "x,y,z,dx,dy,dz\n0,-20,0,0.02,1,0\n");
    // With a stated step, the method is implicit: a rejected step costs hundreds of gradients.
    constexpr int max_gradients = 5000;
    for (const std::string method : {"", "gauss8", "gauss4", "midpoint", "dp54", "rk4"})
        for (const std::string settings : {"", "step = 0.2\n", "rescale = \"r\"\nstep = 0.2\n"}) {
            if (method == "rk4" && settings.empty()) continue;
            const std::string integrator = settings + (method.empty() ? "" : "method = \"" + method + "\"\n");
            SCOPED_TRACE(integrator);
            write("ingoing.toml", scene("-", integrator));
            const Outcome outcome = run("trace ingoing.toml --rays rays.csv");
            EXPECT_NE(outcome.err.find("flip the sign of the null vector"), std::string::npos) << outcome.err;
            const json report = json::parse(run("trace ingoing.toml --rays rays.csv --quiet --json").out);
            EXPECT_EQ(report["status"]["failed"], 1);
            EXPECT_LE(report["gradients_per_ray"], max_gradients);
            write("outgoing.toml", scene("+", integrator));
            const Outcome regular = run("trace outgoing.toml --rays rays.csv");
            EXPECT_EQ(regular.err, "");
            EXPECT_NE(regular.out.find("captured"), std::string::npos) << regular.out;
        }
}

TEST_F(Warnings, AreNotPrintedForTheScenesOfTheGallery) {
    for (const auto& entry : std::filesystem::directory_iterator(KAGERO_SCENES)) {
        if (entry.path().extension() != ".toml") continue;
        SCOPED_TRACE(entry.path().filename().string());
        const json report = json::parse(run("check '" + entry.path().string() + "' --quiet --json").out);
        EXPECT_EQ(report["warnings"].size(), 0u) << report["warnings"];
    }
}

}  // namespace
}  // namespace kagero::test
