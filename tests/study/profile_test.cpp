// Tests of `kagero profile`: its numbers must be consistent and its files readable. Run times are not tested.
#include "tests/support/hole_scene.h"
#include "tests/support/plan_fixture.h"

#include "render/operation_count.h"
#include "study/profile.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <atomic>
#include <map>

namespace kagero::test {
namespace {

using nlohmann::json;

class ProfileVerb : public HoleTest {
protected:
    void profile(const std::string& more = "") {
        const Outcome outcome =
            run("profile hole.toml --size 75x70 -o report --threads 2 --repeat 1 --quiet --json all.json " + more);
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_EQ(outcome.err, "");
        report_ = json::parse(read("all.json"));
    }
    json report_;
};

TEST_F(ProfileVerb, ProfilesAPartOfThePicture) {
    profile("--crop 10,20,40,50");
    EXPECT_EQ(report_["rays"], 30 * 30);
}

TEST_F(ProfileVerb, WritesAReport) {
    profile();
    EXPECT_EQ(read("all.json"), read("report/profile.json"));
    for (const char* name : {"trace.json", "report.html", "hole.exr"})
        EXPECT_TRUE(exists(std::string("report/") + name)) << name;
    EXPECT_EQ(read("report/hole.exr").find("kagero/energy_error"), std::string::npos);  // not computed
    const std::string page = read("report/report.html");
    EXPECT_EQ(page.find("<script src"), std::string::npos);
    EXPECT_EQ(page.find("<link"), std::string::npos) << "the page must not refer to other files";
    EXPECT_NE(page.find("</html>"), std::string::npos);
    EXPECT_EQ(page.find("nan"), std::string::npos);
}

/// Number of traced columns: the 75 columns of the picture, rounded up to complete blocks of 2 × 2 pixels.
constexpr int traced_width = 76;

TEST_F(ProfileVerb, ReportsAllNumbers) {
    profile();
    for (const char* key : {"scene",
                            "isa",
                            "strategy",
                            "precision",
                            "lanes",
                            "threads",
                            "schedule",
                            "rays",
                            "seconds",
                            "steps",
                            "gradients",
                            "queries",
                            "lane_occupancy",
                            "iteration_occupancy",
                            "queries_per_lane_step",
                            "stages",
                            "thread_times",
                            "roofline",
                            "memory",
                            "overhead",
                            "schedules",
                            "scaling",
                            "tiles"})
        EXPECT_TRUE(report_.contains(key)) << key;
    for (const char* stage : {"predict", "list", "integrate", "query", "refine", "shade", "write"})
        EXPECT_GE(report_["stages"][stage].get<double>(), 0) << stage;
    EXPECT_EQ(report_["rays"], traced_width * 70);
    EXPECT_EQ(report_["schedules"].size(), 3u);
    ASSERT_EQ(report_["scaling"].size(), 2u);
    EXPECT_EQ(report_["scaling"][1]["threads"], 2);
    EXPECT_EQ(report_["thread_times"].size(), 2u);
    EXPECT_GT(report_["memory"]["peak_bytes"], 1 << 20);
    const json& roof = report_["roofline"];
    EXPECT_GT(roof["operations_per_gradient"], 5);
    EXPECT_GT(roof["peak_gflops_one_thread"], 0);
    EXPECT_GT(roof["share_of_peak"], 0);
}

TEST_F(ProfileVerb, CoversTheFilmOnceWithTiles) {
    for (const char* schedule : {"scanline", "tiles", "predicted"}) {
        profile(std::string("--schedule ") + schedule);
        EXPECT_EQ(report_["schedule"], schedule);
        std::vector<int> tile_counts(traced_width * 70);
        std::uint64_t gradients = 0;
        for (const json& tile : report_["tiles"]["rows"]) {
            for (int y = tile["y0"]; y < tile["y1"]; ++y)
                for (int x = tile["x0"]; x < tile["x1"]; ++x) ++tile_counts.at(std::size_t(traced_width * y + x));
            EXPECT_LE(tile["begin"], tile["end"]);
            EXPECT_LT(tile["thread"], 2);
            gradients += tile["gradients"].get<std::uint64_t>();
        }
        EXPECT_EQ(std::count(tile_counts.begin(), tile_counts.end(), 1), traced_width * 70) << schedule;
        EXPECT_EQ(gradients, report_["gradients"]) << schedule;
    }
    const double correlation = report_["tiles"]["correlation"];
    EXPECT_GE(correlation, -1);
    EXPECT_LE(correlation, 1);
}

// The format is Chrome's trace event format. Two events of one thread must be disjoint, or one must contain the other.
TEST_F(ProfileVerb, WritesATraceOfNestedEvents) {
    profile();
    const json trace = json::parse(read("report/trace.json"));
    // For each thread, the begin and end of the events that enclose the current event.
    std::map<int, std::vector<std::pair<long long, long long>>> enclosing_events;
    std::size_t tiles = 0;
    for (const json& event : trace["traceEvents"]) {
        if (event["ph"] == "M") continue;
        ASSERT_EQ(event["ph"], "X");
        tiles += event["name"].get<std::string>().starts_with("tile ");
        ASSERT_TRUE(event["ts"].is_number_integer() && event["dur"].is_number_integer());
        const long long begin = event["ts"], end = begin + event["dur"].get<long long>();
        EXPECT_GE(begin, 0);
        EXPECT_GE(end, begin);
        auto& enclosing = enclosing_events[event["tid"]];
        while (!enclosing.empty() && begin >= enclosing.back().second) enclosing.pop_back();
        EXPECT_TRUE(enclosing.empty() || end <= enclosing.back().second) << event;
        enclosing.emplace_back(begin, end);
    }
    EXPECT_EQ(tiles, report_["tiles"]["count"]);
}

TEST_F(ProfileVerb, CountsNoOperationsOfStraightRays) {
    profile("-D space.rg=0");
    EXPECT_EQ(report_["schedule"], "tiles");
    EXPECT_TRUE(report_["tiles"]["correlation"].is_null());
    EXPECT_EQ(report_["roofline"]["operations"], 0);
}

TEST_F(ProfileVerb, RefusesWrongInput) {
    EXPECT_EQ(run("profile").status, 2);
    EXPECT_EQ(run("profile hole.toml --repeat 0").status, 2);
    EXPECT_EQ(run("profile hole.toml -o hole.toml").status, 2);
}

Options with_prediction() {
    Options options;
    options.schedule = Schedule::predicted;
    return options;
}

/// Renders a picture and returns the record of each tile, with its predicted cost and its counters. The keys are the
/// corners x0, y0.
std::map<std::array<std::uint32_t, 2>, TileRecord> tiles_of(const Plan& plan) {
    Film film(plan.description().film.width, plan.description().film.height, {"color"});
    Recording recording;
    RunControl control;
    control.recording = &recording;
    render(plan, film, control);
    std::map<std::array<std::uint32_t, 2>, TileRecord> tiles;
    for (const TileRecord& record : recording.tiles) tiles[{record.tile.x0, record.tile.y0}] = record;
    return tiles;
}

TEST(Profile, KeepsTheCompleteRoundsIfInterrupted) {
    const auto plan = plan_of_file(scene_file("room.toml"), {"film.size=[64,40]"});
    plan->run.threads = 1;
    Film film(64, 40, {"color"});
    std::atomic<bool> stop = false;
    const auto halfway = [&](double done, double) { stop = done > 0.5; };
    const Profile interrupted = profile(*plan, film, 3, halfway, &stop);
    EXPECT_TRUE(interrupted.interrupted);
    EXPECT_EQ(interrupted.rounds, 1u);
    EXPECT_EQ(interrupted.schedules.size(), 3u);
    EXPECT_GT(interrupted.stages.integrate, 0);
    stop = false;
    const Profile none = profile(*plan, film, 3, [&](double, double) { stop = true; }, &stop);
    EXPECT_TRUE(none.interrupted);
    EXPECT_EQ(none.rounds, 0u);
}

// The prediction must not depend on measured times. In the scene galaxy, most of the time is spent on colours.
TEST(Prediction, IsDeterministic) {
    for (const char* scene : {"room.toml", "galaxy.toml"}) {
        const auto plan = plan_of_file(scene_file(scene), {"film.size=[320,200]"}, with_prediction());
        auto expected = tiles_of(*plan);
        for (const auto& [corner, record] : tiles_of(*plan))
            EXPECT_EQ(expected[corner].predicted, record.predicted) << scene;
    }
}

// The predicted costs are compared with the counted operations; a query counts as 400 operations.
TEST(Prediction, CorrelatesWithTheOperationsOfTiles) {
    const auto plan = plan_of_file(scene_file("room.toml"), {}, with_prediction());
    const Operations operations = operations_of(*plan);
    std::vector<double> predicted, counted;
    for (const auto& [corner, record] : tiles_of(*plan)) {
        const Counters& c = record.counters;
        predicted.push_back(record.predicted);
        counted.push_back(operations.per_gradient * double(c.gradients) + operations.per_step * double(c.steps) +
                          400 * double(c.queries));
    }
    EXPECT_GT(*correlation(predicted, counted), 0.9);
}

// Prediction is worthwhile with few tiles per thread, because threads are idle while others process the last tiles. It
// is also worthwhile with many rays per pixel, because kagero then displays the remaining time.
TEST(Prediction, IsChosenForFewTilesPerThreadOrManyRaysPerPixel) {
    const auto chosen = [](unsigned threads, const std::string& size, const std::string& spp) {
        Options options;
        options.threads = threads;
        return schedule_of(*plan_of_file(scene_file("room.toml"), {"film.size=" + size, "film.spp=" + spp}, options));
    };
    EXPECT_EQ(chosen(1, "[320,200]", "1"), Schedule::tiles);  // one thread
    EXPECT_EQ(chosen(2, "[1280,720]", "1"), Schedule::tiles);  // many tiles per thread
    EXPECT_EQ(chosen(2, "[320,200]", "1"), Schedule::predicted);
    EXPECT_EQ(chosen(16, "[1280,720]", "1"), Schedule::predicted);
    EXPECT_EQ(chosen(1, "[1280,720]", "16"), Schedule::predicted);  // many rays per pixel
}

TEST(Correlation, IsPearsonsCoefficient) {
    EXPECT_DOUBLE_EQ(*correlation({1, 2, 3}, {2, 4, 6}), 1);
    EXPECT_DOUBLE_EQ(*correlation({1, 2, 3}, {3, 2, 1}), -1);
    EXPECT_DOUBLE_EQ(*correlation({1, 2, 3}, {1, 5, 1}), 0);
    EXPECT_FALSE(correlation({1, 1, 1}, {1, 2, 3}));
    EXPECT_FALSE(correlation({}, {}));
}

}  // namespace
}  // namespace kagero::test
