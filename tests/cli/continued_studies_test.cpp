// Tests that `error --resume` and `stability --resume` continue after kill -9, and do not repeat finished work.
#include "tests/support/program.h"

#include <nlohmann/json.hpp>

namespace kagero::test {
namespace {

using nlohmann::json;

class ContinuedStudies : public ProgramTest {
protected:
    /// Runs kagero, and kills it when its journal has more than `lines` lines. Returns the journal.
    std::string killed_after(std::size_t lines, const std::string& journal, const std::string& arguments) const {
        const std::string script = "'" KAGERO_BINARY "' " + arguments + " & p=$!; while [ $(cat '" + journal +
                                   "' 2>/dev/null | wc -l) -le " + std::to_string(lines) +
                                   " ] && kill -0 $p 2>/dev/null; do sleep 0.01; done; "
                                   "kill -9 $p; wait $p; :";
        run_program("sh", "-c \"" + escaped(script) + "\"");
        return read(journal);
    }

private:
    /// Returns a text for double quotes in a shell.
    static std::string escaped(const std::string& text) {
        std::string result;
        for (const char c : text) {
            if (c == '$' || c == '"' || c == '\\') result += '\\';
            result += c;
        }
        return result;
    }
};

TEST_F(ContinuedStudies, OfErrorsKeepFinishedPoints) {
    const std::string study = "error '" KAGERO_SCENES "/hole.toml' --quick --sample 8x8 --quiet --precision double";
    ASSERT_EQ(run(study + " -o whole --json whole.json").status, 0);
    const std::string journal = killed_after(5, "out/error.journal", study + " -o out --resume");
    ASSERT_GT(std::count(journal.begin(), journal.end(), '\n'), 5);
    EXPECT_FALSE(std::filesystem::exists(directory_ / "out/results.json"));
    const Outcome other = run(study + " -o out --resume --threads 2");
    EXPECT_EQ(other.status, 2);
    EXPECT_NE(other.err.find("the number of threads"), std::string::npos) << other.err;
    const Outcome rest = run(study + " -o out --resume --json rest.json");
    ASSERT_EQ(rest.status, 0) << rest.err;
    EXPECT_FALSE(std::filesystem::exists(directory_ / "out/error.journal"));
    json whole = json::parse(read("whole.json")), continued = json::parse(read("rest.json"));
    ASSERT_EQ(whole["curves"].size(), continued["curves"].size());
    for (std::size_t i = 0; i < whole["curves"].size(); ++i) {
        json &expected = whole["curves"][i]["points"], &actual = continued["curves"][i]["points"];
        ASSERT_EQ(expected.size(), actual.size());
        for (std::size_t k = 0; k < expected.size(); ++k)
            for (const char* measured : {"step", "position", "pixels", "gradients_per_ray", "energy_drift"})
                EXPECT_EQ(expected[k][measured], actual[k][measured]) << measured;
    }
}

TEST_F(ContinuedStudies, OfStabilityKeepFinishedCases) {
    const std::string suite = "stability layer-momentum lens-surface unusable-input straight-picture denormals ";
    ASSERT_EQ(run(suite + "-o whole").status, 0);
    const std::string journal = killed_after(1, "out/stability.journal", suite + "-o out --resume");
    ASSERT_GT(std::count(journal.begin(), journal.end(), '\n'), 1);
    const Outcome rest = run(suite + "-o out --resume");
    ASSERT_EQ(rest.status, 0) << rest.err;
    EXPECT_EQ(read("out/stability.json"), read("whole/stability.json"));
    EXPECT_FALSE(std::filesystem::exists(directory_ / "out/stability.journal"));
}

}  // namespace
}  // namespace kagero::test
