// Tests of renders that are interrupted and continue from their journal.
#include "tests/support/hole_scene.h"
#include "tests/support/part_fixture.h"

#include <chrono>
#include <random>

namespace kagero::test {
namespace {

/// A picture of 64 tiles whose tracing takes about a second.
const std::string slow =
    "render hole.toml --size 256x256 --integrator gauss8 --step 0.01 --threads 2 "
    "--layers color,steps ";

class Resume : public HoleTest {
protected:
    void SetUp() override {
        HoleTest::SetUp();
        setenv("KAGERO_JOURNAL_INTERVAL", "0.02", 1);
        const auto begin = std::chrono::steady_clock::now();
        ASSERT_EQ(run(slow + "--quiet -o whole.exr").status, 0);
        seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    }
    /// Runs a command that a signal ends after a share of the time of the whole render. The script returns when the
    /// process has ended.
    Outcome run_until(double share, const std::string& signal, const std::string& arguments) const {
        std::ofstream(output_ / "until.sh")
            << "\"$@\" & sleep " << share * seconds_ << "; kill -" << signal << " $! 2>/dev/null; wait $!\n";
        return run(arguments, "sh '" + (output_ / "until.sh").string() + "'");
    }
    void expect_refusal(const std::string& command, const std::string& text) const {
        const std::string journal = read("a.exr.journal");
        const Outcome outcome = run(command);
        EXPECT_EQ(outcome.status, 2) << command;
        EXPECT_NE(outcome.err.find(text), std::string::npos) << text << "\nis not in\n" << outcome.err;
        EXPECT_TRUE(read("a.exr.journal") == journal) << "the journal has changed";
    }
    /// Leaves the journal of an unfinished render to a.exr.
    void leave_journal() const {
        for (double share = 0.6; !exists("a.exr.journal") && share < 10; share *= 0.9) {
            std::filesystem::remove(directory_ / "a.exr");
            run_until(share, "TERM", slow + "--quiet --resume -o a.exr");
        }
        ASSERT_TRUE(exists("a.exr.journal"));
    }

    void TearDown() override {
        unsetenv("KAGERO_JOURNAL_INTERVAL");
        HoleTest::TearDown();
    }

    double seconds_ = 0;
};

// KAGERO_KILLS sets the number of kills.
TEST_F(Resume, GivesTheSamePictureAfterKills) {
    const char* variable = std::getenv("KAGERO_KILLS");
    const int kills = variable ? std::atoi(variable) : 6;
    std::mt19937 random(1);
    std::uniform_real_distribution<double> share(0.1, 0.9);
    int continued = 0;
    for (int i = 0; i < kills; ++i) {
        const Outcome outcome = run_until(share(random), "KILL", slow + "--resume -o a.exr");
        continued += outcome.err.find("continues from a.exr.journal") != std::string::npos;
        if (outcome.status != 0) continue;
        EXPECT_TRUE(read("a.exr") == read("whole.exr"));
        EXPECT_FALSE(exists("a.exr.journal"));
    }
    const Outcome last = run(slow + "--resume -o a.exr --threads 1");
    ASSERT_EQ(last.status, 0) << last.err;
    EXPECT_TRUE(read("a.exr") == read("whole.exr"));
    EXPECT_EQ(files(), (std::set<std::string>{"hole.toml", "whole.exr", "a.exr"}));
    EXPECT_GT(continued, 0) << "no run continued from a journal";
}

TEST_F(Resume, KeepsTheJournalAfterASignal) {
    for (const char* signal : {"INT", "TERM"}) {
        Outcome outcome{};
        for (double share = 0.6; share > 0.2 && outcome.status != 130; share *= 0.9) {
            for (const char* file : {"a.exr", "a.exr.journal"}) std::filesystem::remove(directory_ / file);
            outcome = run_until(share, signal, slow + "--resume -o a.exr");
        }
        ASSERT_EQ(outcome.status, 130) << outcome.err;
        EXPECT_NE(outcome.err.find("tiles are in a.exr.journal; the same command continues"), std::string::npos)
            << outcome.err;
        EXPECT_FALSE(exists("a.exr"));
        const Outcome so_far = run("merge --incomplete a.exr.journal -o so-far.exr");
        EXPECT_EQ(so_far.status, 0) << so_far.err;
        const Outcome resumed = run(slow + "--resume -o a.exr --json report.json");
        EXPECT_EQ(resumed.status, 0) << resumed.err;
        EXPECT_TRUE(read("a.exr") == read("whole.exr")) << signal;
        EXPECT_NE(read("report.json").find("earlier_rays"), std::string::npos);
    }
}

TEST_F(Resume, ContinuesAfterATimeLimitAndForParts) {
    const std::string limit = " --time-limit " + std::to_string(0.3 * seconds_);
    const Outcome limited = run(slow + "--resume -o a.exr" + limit);
    EXPECT_EQ(limited.status, 0) << limited.err;
    EXPECT_TRUE(exists("a.exr"));
    EXPECT_EQ(run(slow + "--quiet --resume -o a.exr").status, 0);
    EXPECT_TRUE(read("a.exr") == read("whole.exr"));
    for (const std::string number : {"1", "2"}) {
        run_until(0.4, "KILL", slow + "--resume --part " + number + "/2 -o " + number + ".part");
        const Outcome part = run(slow + "--resume --part " + number + "/2 -o " + number + ".part");
        EXPECT_EQ(part.status, 0) << part.err;
    }
    EXPECT_EQ(run("merge --quiet 1.part 2.part -o merged.exr").status, 0);
    EXPECT_TRUE(read("merged.exr") == read("whole.exr"));
}

// Without a journal, the part itself contains the finished tiles.
TEST_F(Resume, OfAnInterruptedPartNeedsAJournal) {
    Outcome outcome{};
    for (double share = 0.6; share > 0.2 && outcome.status != 130; share *= 0.9)
        outcome = run_until(share, "INT", slow + "--part 1/1 -o a.part");
    ASSERT_EQ(outcome.status, 130) << outcome.err;
    EXPECT_NE(outcome.err.find("interrupted; part 1/1 so far is in a.part, with "), std::string::npos) << outcome.err;
    const Outcome refused = run("merge a.part -o a.exr");
    EXPECT_EQ(refused.status, 2);
    EXPECT_NE(refused.err.find("a.part is incomplete: it contains only "), std::string::npos) << refused.err;
    EXPECT_EQ(run("merge --incomplete a.part -o a.exr").status, 0);
}

TEST_F(Resume, RefusesTheJournalOfAnotherRender) {
    leave_journal();
    expect_refusal(slow + "--resume -o a.exr --seed 3", "the list of overrides is");
    expect_refusal(slow + "--resume -o a.exr --precision float", "--precision is auto in a.exr.journal, but float in");
    expect_refusal(slow + "--resume -o a.exr --crop 0,0,64,64", "the rendered window is 0,0,256,256 in");
    expect_refusal(slow + "--resume -o a.exr --part 1/2", "the part is 1/1");
    write("hole.toml", "# one more line\n" + std::string(hole));
    expect_refusal(slow + "--resume -o a.exr", "the scene differs between a.exr.journal and this run, first in line 1");
    write("hole.toml", hole);
    {
        const Journal other_process((directory_ / "a.exr.journal").string());
        expect_refusal(slow + "--resume -o a.exr", "another process uses the journal 'a.exr.journal'");
    }
    std::ifstream in(directory_ / "a.exr.journal", std::ios::binary);
    TileFileHeader header = *read_header(in, "a.exr.journal");
    const std::string tiles{std::istreambuf_iterator<char>(in), {}}, journal = read("a.exr.journal");
    for (auto& [name, value] : header.identity)
        if (name == "the version of kagero") value = "0.0.1";
    write("a.exr.journal", encode_header(header) + tiles);
    expect_refusal(slow + "--resume -o a.exr", "the version of kagero is 0.0.1 in a.exr.journal");
    write("a.exr.journal", "someone's notes");
    expect_refusal(slow + "--resume -o a.exr", "a.exr.journal is not a part or journal of kagero");
    write("a.exr.journal", journal);
    EXPECT_EQ(run(slow + "--resume -o a.exr").status, 0);
    EXPECT_TRUE(read("a.exr") == read("whole.exr"));
}

// The choices of the journal are used, and no trial replaces them.
TEST_F(Resume, KeepsTheChoicesOfTheTrial) {
    const std::string render = "render hole.toml --size 256x256 --threads 1 --resume -o b.exr ";
    ASSERT_EQ(run(render + "--time-limit 1e-6").status, 0);
    std::ifstream in(directory_ / "b.exr.journal", std::ios::binary);
    TileFileHeader header = *read_header(in, "b.exr.journal");
    for (auto& [name, value] : header.choices)
        if (name == "step") value = "0.0123";
    write("b.exr.journal", encode_header(header));
    ASSERT_EQ(run(render + "--json report.json").status, 0);
    EXPECT_NE(read("report.json").find("\"step\": 0.0123"), std::string::npos) << read("report.json");
}

// A limit on the size of files stands for a full disk.
TEST_F(Resume, ContinuesAfterAFullDisk) {
    const Outcome full = run(slow + "--resume -o a.exr", "trap '' XFSZ; ulimit -f 200;");
    EXPECT_EQ(full.status, 1) << full.err;
    EXPECT_NE(full.err.find("cannot write the journal 'a.exr.journal': File too large"), std::string::npos) << full.err;
    const Outcome resumed = run(slow + "--resume -o a.exr");
    EXPECT_EQ(resumed.status, 0) << resumed.err;
    EXPECT_NE(resumed.err.find("continues from a.exr.journal"), std::string::npos) << resumed.err;
    EXPECT_TRUE(read("a.exr") == read("whole.exr"));
}

// A record is written at the latest after the interval, so no tile is in the journal of a process that ends earlier.
TEST_F(Resume, WritesTilesAtIntervals) {
    setenv("KAGERO_JOURNAL_INTERVAL", "1000", 1);
    for (double share = 0.6; !exists("a.exr.journal") && share > 0.1; share *= 0.9) {
        std::filesystem::remove(directory_ / "a.exr");
        run_until(share, "KILL", slow + "--quiet --resume -o a.exr");
    }
    ASSERT_TRUE(exists("a.exr.journal"));
    const Outcome resumed = run(slow + "--resume -o a.exr");
    EXPECT_NE(resumed.err.find("continues from a.exr.journal: 0 of 64 tiles are finished"), std::string::npos)
        << resumed.err;
    EXPECT_TRUE(read("a.exr") == read("whole.exr"));
    for (const char* wrong : {"-1", "often", "1e9", "nan"}) {
        setenv("KAGERO_JOURNAL_INTERVAL", wrong, 1);
        const Outcome refused = run(slow + "--resume -o b.exr");
        EXPECT_EQ(refused.status, 2) << wrong;
        EXPECT_FALSE(exists("b.exr.journal")) << wrong;
        EXPECT_NE(refused.err.find("KAGERO_JOURNAL_INTERVAL: '" + std::string(wrong) + "' is not a number of seconds"),
                  std::string::npos)
            << refused.err;
    }
}

// --json needs the error of H of all rays, which the finished tiles do not have.
TEST_F(Resume, RefusesAJournalWithoutTheErrorOfH) {
    const std::string render = "render hole.toml --size 256x256 --threads 1 --resume -o b.png ";
    ASSERT_EQ(run(render + "--time-limit 1e-6").status, 0);
    const Outcome refused = run(render + "--json report.json");
    EXPECT_EQ(refused.status, 2);
    EXPECT_NE(refused.err.find(
                  "the measurement of the error of H, which --json and .exr need, is off in b.png.journal"),
              std::string::npos)
        << refused.err;
    EXPECT_EQ(run(render).status, 0);
}

TEST_F(Resume, RefusesAChangedTexture) {
    ASSERT_EQ(run("render hole.toml --quiet -o sky.png").status, 0);
    const std::string text = hole;
    write("sky.toml", text.substr(0, text.rfind("checker")) + "texture = \"sky.png\"\n");
    const std::string render = "render sky.toml --size 128x128 --resume -o c.exr ";
    ASSERT_EQ(run(render + "--time-limit 1e-6").status, 0);
    ASSERT_TRUE(exists("c.exr.journal"));
    ASSERT_EQ(run("render hole.toml --quiet --size 17x8 -o sky.png").status, 0);
    const Outcome outcome = run(render);
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find("the content of the texture of sky is "), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace kagero::test
