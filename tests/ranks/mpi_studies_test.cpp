// Tests of `kagero sweep --mpi` and `kagero error --mpi` with the mpirun of this machine.
#include "tests/support/mpi_fixture.h"

#include <nlohmann/json.hpp>

namespace kagero::test {
namespace {

using nlohmann::json;

/// Removes everything from a report that depends on measured times.
void remove_times(json& value) {
    if (value.is_object())
        for (const char* key : {"seconds", "ns_per_ray", "ns_per_ray_without_surfaces", "cheapest", "strategies",
                                "timed_runs", "threads"})
            value.erase(key);
    for (json& item : value)
        if (item.is_structured()) remove_times(item);
}

class MpiStudies : public MpiTest {
protected:
    void SetUp() override {
        MpiTest::SetUp();
        std::string rays = "x,y,z,dx,dy,dz\n";
        for (int i = 0; i < 300; ++i)
            rays += "-2," + std::to_string(0.02 * (i - 150)) + "," + std::to_string(0.01 * (i % 7)) + ",1,0,0.01\n";
        write("rays.csv", rays);
    }
    /// Returns the points of a report by the names of their curves, without times.
    json points_of(const std::string& file) const {
        json report = json::parse(read(file));
        json curves = report["curves"];
        remove_times(curves);
        return curves;
    }

    const std::string sweep_ = "sweep hole.toml --vary space.rg=0:0.3:101 --rays rays.csv --quiet --threads 1 ";
    const std::string slow_sweep_ =
        "sweep hole.toml --vary space.rg=0.01:0.3:60 --rays rays.csv --quiet --threads 1 --integrator gauss8 "
        "--step 0.02 ";
    const Files sweep_files_{"a.csv", "a.csv.journal"};
    const std::string study_ = "error hole.toml --quick --sample 16x16 --quiet --precision double ";
};

TEST_F(MpiStudies, GiveTheSameSweepForAnyNumberOfRanks) {
    ASSERT_EQ(run(sweep_ + "-o one.csv").status, 0);
    ASSERT_EQ(lines_of(read("one.csv")).size(), 101u * 300 + 1);
    for (const int count : {1, 3}) {
        const Outcome outcome = on_ranks(count, sweep_ + "-o a.csv");
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_TRUE(read("a.csv") == read("one.csv")) << count << " ranks";
    }
}

// A signal reaches one rank only, and all ranks end. The tests share the sweep that is their reference.
TEST_F(MpiStudies, ContinueASweepAfterAKilledRankAndASignal) {
    ASSERT_EQ(run(slow_sweep_ + "-o one.csv").status, 0);
    EXPECT_NE(signal_rank(1, "KILL", slow_sweep_ + "--resume -o a.csv", sweep_files_, 50000).status, 0);
    EXPECT_FALSE(exists("a.csv"));
    ASSERT_TRUE(exists("a.csv.journal"));
    const Outcome outcome = on_ranks(2, slow_sweep_ + "--resume -o a.csv --json a.json");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_GT(json::parse(read("a.json"))["blocks_kept"], 0);
    EXPECT_TRUE(read("a.csv") == read("one.csv"));
    EXPECT_FALSE(exists("a.csv.journal"));

    const Outcome stopped = signal_rank(2, "TERM", slow_sweep_ + "--resume -o a.csv", sweep_files_, 50000);
    EXPECT_EQ(stopped.status, 130) << stopped.err;
    EXPECT_FALSE(exists("a.csv"));
    ASSERT_EQ(run(slow_sweep_ + "--resume -o a.csv").status, 0);
    EXPECT_TRUE(read("a.csv") == read("one.csv"));
}

TEST_F(MpiStudies, MeasureTheSameErrorsOnSeveralRanks) {
    ASSERT_EQ(run(study_ + "-o one --json one.json").status, 0);
    const json expected = points_of("one.json");
    ASSERT_GT(expected.size(), 3u);
    const Outcome outcome = on_ranks(3, study_ + "-o a --json a.json");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(points_of("a.json"), expected);
}

TEST_F(MpiStudies, ContinueErrorsAfterAKilledRank) {
    ASSERT_EQ(run(study_ + "-o one --json one.json").status, 0);
    EXPECT_NE(signal_rank(1, "KILL", study_ + "--resume -o a", {"a", "a/error.journal"}, 8000).status, 0);
    EXPECT_FALSE(exists("a/results.json"));
    ASSERT_TRUE(exists("a/error.journal"));
    const Outcome outcome = on_ranks(2, study_ + "--resume -o a --json a.json");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(points_of("a.json"), points_of("one.json"));
    EXPECT_FALSE(exists("a/error.journal"));
}

}  // namespace
}  // namespace kagero::test
