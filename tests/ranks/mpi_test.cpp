// Tests of `kagero render --mpi` with the mpirun of this machine. They are skipped if the MPI module is not built.
#include "tests/support/mpi_fixture.h"

#include <nlohmann/json.hpp>

namespace kagero::test {
namespace {

const std::string small = "hole.toml --size 96x80 --layers color,steps --quiet ";
/// A picture of 25 tiles, each of which takes some hundredths of a second.
const std::string slow = "hole.toml --size 160x160 --integrator gauss8 --step 0.004 --layers color,steps ";
const std::string resumed = "render " + slow + "--threads 1 --resume -o a.exr ";

class Mpi : public MpiTest {
protected:
    /// Begins or continues the slow render on three ranks, and sends a signal to rank `rank` when the journal contains
    /// more tiles than before.
    Outcome signal_slow_render(int rank, const std::string& signal) const {
        return signal_rank(rank, signal, resumed, {"a.exr", "a.exr.journal"}, 6000);
    }
    /// Continues the slow render without MPI, or on several ranks, and expects the picture of one uninterrupted render.
    void continue_slow_render(int ranks) const {
        ASSERT_TRUE(exists("a.exr.journal"));
        const Outcome outcome = ranks == 0 ? run(resumed) : on_ranks(ranks, resumed);
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_NE(outcome.err.find("continues from a.exr.journal"), std::string::npos) << outcome.err;
        EXPECT_TRUE(read("a.exr") == read("one.exr")) << ranks << " ranks";
        EXPECT_FALSE(exists("a.exr.journal"));
    }
};

TEST_F(Mpi, GivesTheSameBytesForAnyNumberOfRanks) {
    ASSERT_EQ(run("render " + small + "-o one.exr").status, 0);
    for (const int count : {1, 2, 3}) {
        const Outcome outcome = on_ranks(count, "render " + small + "-o a.exr --json -");
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_TRUE(read("a.exr") == read("one.exr")) << count << " ranks";
        const auto json = nlohmann::json::parse(outcome.out);
        ASSERT_EQ(json["ranks"].size(), static_cast<std::size_t>(count));
        std::uint64_t tiles = 0;
        for (const auto& rank : json["ranks"]) tiles += rank["tiles"].get<std::uint64_t>();
        EXPECT_EQ(tiles, 9u);
    }
}

// A signal reaches one rank only, and all ranks end. The tests share the render that is their reference.
TEST_F(Mpi, ContinuesAfterAKilledRankASignalAndATimeLimit) {
    ASSERT_EQ(run("render " + slow + "--threads 2 --quiet -o one.exr").status, 0);
    EXPECT_NE(signal_slow_render(1, "KILL").status, 0);
    EXPECT_FALSE(exists("a.exr"));
    continue_slow_render(2);

    for (const int rank : {0, 2}) {  // the second run continues the journal of the first one
        const Outcome outcome = signal_slow_render(rank, "TERM");
        EXPECT_EQ(outcome.status, 130) << outcome.err;
        EXPECT_NE(outcome.err.find("tiles are in a.exr.journal; the same command continues"), std::string::npos)
            << outcome.err;
    }
    continue_slow_render(0);

    const Outcome limited = on_ranks(2, resumed + "--time-limit 0.05");
    EXPECT_EQ(limited.status, 0) << limited.err;
    EXPECT_NE(limited.err.find("the time limit was reached"), std::string::npos) << limited.err;
    continue_slow_render(3);
}

TEST_F(Mpi, RendersTheFramesOfAnAnimation) {
    const std::string scene = std::string(KAGERO_SCENES) + "/fall.toml --size 32x24 --frames 10:15 --quiet ";
    ASSERT_EQ(run("render " + scene + "-o one-%02d.png").status, 0);
    ASSERT_EQ(on_ranks(3, "render " + scene + "-o a-%02d.png").status, 0);
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
    const Outcome outcome = on_ranks(2, "render " + scene + "--send-files -o a.exr");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(read("a.exr") == read("one.exr"));
}

TEST_F(Mpi, ReportsAnErrorOnce) {
    const Outcome outcome = on_ranks(3, "render missing.toml");
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
        {"error hole.toml --send-files", "--send-files sends files to the processes of --mpi"},
        {"sweep hole.toml --send-files --vary space.rg=0,0.1", "--send-files sends files to the processes of --mpi"},
        {"compare hole.toml --mpi", "compare has no option \"--mpi\""},
    };
    for (const auto& [arguments, reason] : refusals) {
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.status, 2) << arguments;
        EXPECT_NE(outcome.err.find(reason), std::string::npos) << outcome.err;
    }
}

// MPI costs nothing without --mpi: neither the program nor the library is linked to it, and a render does not load it.
TEST_F(MpiOptions, AreTheOnlyReasonToLoadMpi) {
    const std::string library = (std::filesystem::path(KAGERO_BINARY).parent_path().parent_path() / "lib").string();
    const Outcome linked = run_program("ldd", std::string("'") + KAGERO_BINARY + "' '" + library + "/libkagero.so'");
    ASSERT_EQ(linked.status, 0) << linked.err;
    EXPECT_NE(linked.out.find("libembree"), std::string::npos) << linked.out;
    EXPECT_EQ(linked.out.find("mpi"), std::string::npos) << linked.out;
    const Outcome rendered = run("render hole.toml --quiet -o a.exr", "LD_DEBUG=files");
    ASSERT_EQ(rendered.status, 0);
    EXPECT_NE(rendered.err.find("kagero-openexr.so"), std::string::npos) << "modules are not listed";
    EXPECT_EQ(rendered.err.find("kagero-mpi"), std::string::npos);
    EXPECT_EQ(rendered.err.find("libmpi"), std::string::npos);
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
