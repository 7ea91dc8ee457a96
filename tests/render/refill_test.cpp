// New rays into finished lanes: which rays share a packet, and when, is nobody's business but the clock's.
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace kagero::test {
namespace {

std::unique_ptr<Plan> room(const std::string& refill, Overrides overrides, const std::string& strategy, bool with_camera) {
    overrides.insert(overrides.end(), {"integrator.refill=" + refill, "film.size=[40, 30]"});
    return plan_of_file(std::string(KAGERO_SCENES) + "/room.toml", overrides, with_strategy(strategy), with_camera);
}

/// Rays that take very different numbers of steps side by side, a few of them unusable.
std::vector<RayInput> rays(std::size_t count = 501) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> inside(-0.9, 0.9), any(-1, 1);
    std::vector<RayInput> all(count);
    for (RayInput& ray : all) ray = {{inside(random), inside(random), inside(random)}, {any(random), any(random), any(random)}};
    all[17].direction = {0, 0, 0};
    all[300].position = {0, 0, 0};
    return all;
}

struct Traced {
    std::vector<RayEnd> ends;
    RunReport report;
};
Traced traced(const std::string& refill, const std::string& method, const std::string& strategy) {
    const auto plan = room(refill, {"integrator.method=" + method}, strategy, false);
    Traced result;
    result.report = trace(*plan, start_rays(*plan, rays()), result.ends);
    return result;
}

void expect_same(const RayEnd& a, const RayEnd& b) {
    EXPECT_EQ(a.status, b.status);
    EXPECT_EQ(a.failure, b.failure);
    if (a.status == Status::failed) return;
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(a.q[k] == b.q[k] && a.p[k] == b.p[k] && a.v[k] == b.v[k]);
    EXPECT_EQ(a.parameter, b.parameter);
    EXPECT_EQ(a.steps, b.steps);
    EXPECT_EQ(a.gradients, b.gradients);
    EXPECT_EQ(a.iterations, b.iterations);
    EXPECT_EQ(a.surface, b.surface);
}

TEST(Refill, ChangesNoRay) {
    for (const char* strategy : {"packet", "scalar"})
        for (const char* method : {"gauss8", "verlet", "rk4", "dp54"}) {
            SCOPED_TRACE(std::string(strategy) + ", " + method);
            const Traced on = traced("on", method, strategy), off = traced("off", method, strategy);
            ASSERT_EQ(on.ends.size(), off.ends.size());
            for (std::size_t i = 0; i < on.ends.size(); ++i) {
                SCOPED_TRACE(i);
                expect_same(on.ends[i], off.ends[i]);
            }
            for (std::uint32_t s = 0; s < status_count; ++s) EXPECT_EQ(on.report.counters.ended[s], off.report.counters.ended[s]);
        }
}

TEST(Refill, KeepsLanesBusy) {
    const auto occupancy = [](const Traced& run) {
        return double(run.report.counters.active_lane_steps) / double(run.report.counters.issued_lane_steps);
    };
    const Traced on = traced("on", "gauss8", "packet"), off = traced("off", "gauss8", "packet");
    EXPECT_GT(occupancy(on), occupancy(off));
    EXPECT_EQ(on.report.counters.active_lane_steps, off.report.counters.active_lane_steps);
}

/// Lane occupancy of a list of rays that a finished lane may or may not be refilled from.
double occupancy(const std::vector<RayInput>& list, const std::string& refill, const std::string& step) {
    const auto plan = room(refill, {"integrator.method=verlet", "integrator.step=" + step}, "packet", false);
    std::vector<RayEnd> ends;
    const RunReport report = trace(*plan, start_rays(*plan, list), ends);
    return double(report.counters.active_lane_steps) / double(report.counters.issued_lane_steps);
}

// A list whose sixteenths do not begin with a packet.
TEST(Refill, IsTakenUnaskedWhereLanesStandEmptyForLong) {
    std::vector<RayInput> mixed = rays(9519), coherent;
    const double count = double(mixed.size());
    for (double k = 0; k < count; ++k) coherent.push_back({{-0.9, 0.3, 0.1}, {1, 1.8 * k / count - 0.9, 0.2}});
    for (const auto* list : {&mixed, &coherent}) EXPECT_NE(occupancy(*list, "on", "0.05"), occupancy(*list, "off", "0.05"));
    EXPECT_EQ(occupancy(mixed, "auto", "0.05"), occupancy(mixed, "on", "0.05"));
    EXPECT_EQ(occupancy(mixed, "auto", "1"), occupancy(mixed, "off", "1"));
    EXPECT_EQ(occupancy(coherent, "auto", "0.05"), occupancy(coherent, "off", "0.05"));
}

/// A window of directions, row by row.
std::vector<RayInput> window() {
    std::vector<RayInput> list;
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) list.push_back({{0.22, -0.92, 0.16}, {-0.22 + x / 32.0 - 1, 0.92, -0.16 + y / 32.0 - 1}});
    return list;
}

TEST(OrderOfRays, IsNobodysBusiness) {
    const std::vector<RayInput> ordered = window();
    std::vector<std::size_t> places(ordered.size());
    std::iota(places.begin(), places.end(), 0);
    std::shuffle(places.begin(), places.end(), std::mt19937(7));
    std::vector<RayInput> shuffled;
    for (const std::size_t i : places) shuffled.push_back(ordered[i]);
    const auto plan = room("off", {"integrator.method=gauss8", "integrator.step=0.5"}, "packet", false);
    std::vector<RayEnd> ends, should;
    const RunReport report = trace(*plan, start_rays(*plan, shuffled), ends);
    trace(*plan, start_rays(*plan, ordered), should);
    for (std::size_t i = 0; i < places.size(); ++i) expect_same(ends[i], should[places[i]]);
    // Rays that go together share packets, however they are listed.
    EXPECT_GT(double(report.counters.active_lane_steps), 0.8 * double(report.counters.issued_lane_steps));
    const auto points = trace_paths(*plan, start_rays(*plan, shuffled), ends);
    ASSERT_FALSE(points.empty());
    for (const PathPoint& point : points) {
        if (point.step > 0) continue;
        const Double3& d = shuffled[point.ray].direction;
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(point.v[k], d[k] / std::hypot(d[0], d[1], d[2]), 1e-12);
    }
}

TEST(Refill, ChangesNoPicture) {
    const auto picture = [](const char* refill) {
        const auto plan = room(refill, {}, "packet", true);
        Film film(plan->description().film.width, plan->description().film.height, {"color", "steps", "status", "gradients"});
        render(*plan, film);
        return film;
    };
    const Film on = picture("on"), off = picture("off");
    for (const char* layer : {"steps", "status", "gradients"})
        EXPECT_TRUE(std::equal(on.plane(layer), on.plane(layer) + 40 * 30, off.plane(layer))) << layer;
    EXPECT_TRUE(std::equal(on.plane("color"), on.plane("color") + 3 * 40 * 30, off.plane("color")));
}

}  // namespace
}  // namespace kagero::test
