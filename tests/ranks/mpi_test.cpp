// Tests of `kagero render --mpi` with the mpirun of this machine. They are skipped if the MPI module is not built.
#include "tests/support/hole_scene.h"

#include <nlohmann/json.hpp>

#include <chrono>

namespace kagero::test {
namespace {

const std::string launcher = KAGERO_MPIEXEC;

/// Variables for tests in a container: Open MPI runs as root, and starts more ranks than there are processors. Other
/// implementations ignore them.
const std::string variables =
    "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 "
    "OMPI_MCA_btl_vader_single_copy_mechanism=none ";

const std::string small = "hole.toml --size 96x80 --layers color,steps --quiet ";
/// A picture whose tracing takes a second or more.
const std::string slow = "hole.toml --size 256x256 --integrator gauss8 --step 0.004 --layers color,steps --threads 1 ";

class Mpi : public HoleTest {
protected:
    void SetUp() override {
        HoleTest::SetUp();
        if (launcher.empty())
            GTEST_SKIP() << "the MPI module is not built (.ci/setup test installs mpi-default-dev), or has sanitizers";
    }
    /// Runs `kagero render ARGUMENTS --mpi` on `count` ranks. `rank_command` is the start of the command of a rank.
    Outcome on_ranks(int count, const std::string& arguments, const std::string& rank_command = "") const {
        return run_program(launcher, "-n " + std::to_string(count) + " " + command(arguments, rank_command), variables);
    }
    static std::string command(const std::string& arguments, const std::string& rank_command = "") {
        return rank_command + " '" + KAGERO_BINARY + "' render " + arguments + " --mpi";
    }
    /// Begins the slow render on three ranks, and sends a signal to rank `rank` when the journal contains tiles.
    Outcome signal_rank(int rank, const std::string& signal) const {
        std::filesystem::remove(directory_ / "a.exr.journal");
        std::ofstream(output_ / "rank.sh")
            << "echo $$ > '" << output_.string() << "'/pid-${OMPI_COMM_WORLD_RANK:-$PMI_RANK}\nexec \"$@\"\n";
        std::ofstream(output_ / "signal.sh")
            << "\"$@\" & launcher=$!\nwhile kill -0 $launcher 2>/dev/null; do\n"
            << "  [ $(stat -c %s a.exr.journal 2>/dev/null || echo 0) -gt 100000 ] && break; sleep 0.01\ndone\n"
            << "kill -" << signal << " $(cat '" << output_.string() << "'/pid-" << rank << ")\nwait $launcher\n";
        return run_program("sh",
                           "'" + (output_ / "signal.sh").string() + "' '" + launcher + "' -n 3 " +
                               command(slow + "--resume -o a.exr", "sh '" + (output_ / "rank.sh").string() + "'"),
                           variables);
    }
};

TEST_F(Mpi, GivesTheSameBytesForAnyNumberOfRanks) {
    ASSERT_EQ(run("render " + small + "-o one.exr").status, 0);
    for (const int count : {1, 2, 3}) {
        const Outcome outcome = on_ranks(count, small + "-o a.exr --json -");
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_TRUE(read("a.exr") == read("one.exr")) << count << " ranks";
        const auto json = nlohmann::json::parse(outcome.out);
        ASSERT_EQ(json["ranks"].size(), static_cast<std::size_t>(count));
        std::uint64_t tiles = 0;
        for (const auto& rank : json["ranks"]) tiles += rank["tiles"].get<std::uint64_t>();
        EXPECT_EQ(tiles, 9u);
    }
}

TEST_F(Mpi, ContinuesAfterAKilledRank) {
    ASSERT_EQ(run("render " + slow + "--quiet -o one.exr").status, 0);
    EXPECT_NE(signal_rank(1, "KILL").status, 0);
    EXPECT_FALSE(exists("a.exr"));
    ASSERT_TRUE(exists("a.exr.journal"));
    const Outcome outcome = on_ranks(2, slow + "--resume -o a.exr");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("continues from a.exr.journal"), std::string::npos) << outcome.err;
    EXPECT_TRUE(read("a.exr") == read("one.exr"));
    EXPECT_FALSE(exists("a.exr.journal"));
}

// The signal reaches one rank only, and all ranks end.
TEST_F(Mpi, KeepsTheJournalAfterASignal) {
    ASSERT_EQ(run("render " + slow + "--quiet -o one.exr").status, 0);
    for (const int rank : {0, 2}) {
        const Outcome outcome = signal_rank(rank, "TERM");
        EXPECT_EQ(outcome.status, 130) << outcome.err;
        EXPECT_NE(outcome.err.find("tiles are in a.exr.journal; the same command continues"), std::string::npos)
            << outcome.err;
    }
    ASSERT_EQ(run("render " + slow + "--quiet --resume -o a.exr").status, 0);
    EXPECT_TRUE(read("a.exr") == read("one.exr"));
}

TEST_F(Mpi, ObeysTheTimeLimit) {
    ASSERT_EQ(run("render " + slow + "--quiet -o one.exr").status, 0);
    const Outcome first = on_ranks(2, slow + "--resume --time-limit 0.2 -o a.exr");
    EXPECT_EQ(first.status, 0) << first.err;
    EXPECT_NE(first.err.find("the time limit was reached"), std::string::npos) << first.err;
    ASSERT_EQ(on_ranks(3, slow + "--quiet --resume -o a.exr").status, 0);
    EXPECT_TRUE(read("a.exr") == read("one.exr"));
}

TEST_F(Mpi, RendersTheFramesOfAnAnimation) {
    const std::string scene = std::string(KAGERO_SCENES) + "/fall.toml --size 32x24 --frames 10:15 --quiet ";
    ASSERT_EQ(run("render " + scene + "-o one-%02d.png").status, 0);
    ASSERT_EQ(on_ranks(3, scene + "-o a-%02d.png").status, 0);
    for (int frame = 10; frame < 15; ++frame) {
        const std::string number = std::to_string(frame);
        EXPECT_TRUE(exists("a-" + number + ".png"));
        EXPECT_TRUE(read("a-" + number + ".png") == read("one-" + number + ".png")) << number;
    }
    EXPECT_TRUE(exists("a-frames.json"));
}

TEST_F(Mpi, SendsFiles) {
    const std::string scene = std::string(KAGERO_SCENES) + "/galaxy.toml --size 64x64 --quiet ";
    ASSERT_EQ(run("render " + scene + "-o one.exr").status, 0);
    const Outcome outcome = on_ranks(2, scene + "--send-files -o a.exr");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(read("a.exr") == read("one.exr"));
}

TEST_F(Mpi, ReportsAnErrorOnce) {
    const Outcome outcome = on_ranks(3, "missing.toml");
    EXPECT_EQ(outcome.status, 2);
    const std::size_t first = outcome.err.find("missing.toml");
    EXPECT_NE(first, std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.err.find("missing.toml", first + 1), std::string::npos) << outcome.err;
}

// These refusals need no MPI.
class MpiOptions : public HoleTest {};

TEST_F(MpiOptions, AreRefusedWithAReason) {
    const std::vector<std::pair<std::string, std::string>> refusals{
        {"render hole.toml --send-files", "--send-files sends files to the processes of --mpi"},
        {"error hole.toml --mpi", "error has no option \"--mpi\""},
    };
    for (const auto& [arguments, reason] : refusals) {
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.status, 2) << arguments;
        EXPECT_NE(outcome.err.find(reason), std::string::npos) << outcome.err;
    }
}

// A program without the modules beside it is one that was built without MPI.
TEST_F(MpiOptions, NeedTheModule) {
    std::filesystem::create_directories(output_ / "bin");
    std::filesystem::copy_file(KAGERO_BINARY, output_ / "bin" / "kagero");
    const Outcome outcome = run_program((output_ / "bin" / "kagero").string(), "render hole.toml --mpi");
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find("this kagero has no MPI module"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("--part I/N"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace kagero::test
