// Tests of the assignment of rays to packets and of the refill of lanes, which must not change any result.
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace kagero::test {
namespace {

std::unique_ptr<Plan> room(const std::string& refill, Overrides overrides, const std::string& strategy,
                           bool with_camera) {
    overrides.insert(overrides.end(), {"integrator.refill=" + refill, "film.size=[40, 30]"});
    return plan_of_file(std::string(KAGERO_SCENES) + "/room.toml", overrides, with_strategy(strategy), with_camera);
}

/// Returns random rays whose numbers of steps differ widely. Two of them cannot start.
std::vector<RayInput> rays(std::size_t count = 501) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> inside(-0.9, 0.9), any(-1, 1);
    std::vector<RayInput> all(count);
    for (RayInput& ray : all)
        ray = {{inside(random), inside(random), inside(random)}, {any(random), any(random), any(random)}};
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
            for (std::uint32_t s = 0; s < status_count; ++s)
                EXPECT_EQ(on.report.counters.ended[s], off.report.counters.ended[s]);
        }
}

/// Returns the occupancy: active lane-steps divided by issued lane-steps.
double occupancy_of(const RunReport& report) {
    return double(report.counters.active_lane_steps) / double(report.counters.issued_lane_steps);
}

TEST(Refill, IncreasesTheOccupancy) {
    const Traced on = traced("on", "gauss8", "packet"), off = traced("off", "gauss8", "packet");
    EXPECT_GT(occupancy_of(on.report), occupancy_of(off.report));
    EXPECT_EQ(on.report.counters.active_lane_steps, off.report.counters.active_lane_steps);
}

// The default `auto` must refill lanes for incoherent rays with short steps, because lanes are then inactive for a long
// time. It must not refill lanes for coherent rays or for long steps. The number of rays is proportional to the number
// of lanes, because `auto` does not refill lanes for short lists.
TEST(Refill, IsUsedByDefaultForIncoherentRaysWithManySteps) {
    for (const std::string& isa : supported_isas()) {
        SCOPED_TRACE(isa);
        Options options = with_strategy("packet");
        options.isa = isa;
        const auto plan_with = [&](const std::string& refill, const std::string& step) {
            return plan_of_file(scene_file("room.toml"),
                                {"integrator.method=verlet", "integrator.refill=" + refill, "integrator.step=" + step},
                                options, false);
        };
        const auto occupancy = [&](const std::vector<RayInput>& list, const std::string& refill,
                                   const std::string& step) {
            const auto plan = plan_with(refill, step);
            std::vector<RayEnd> ends;
            return occupancy_of(trace(*plan, start_rays(*plan, list), ends));
        };
        // For its decision, `auto` traces 16 packets at equal distances in the list. A sixteenth of this list is not a
        // multiple of the number of lanes.
        const std::size_t count = 595 * std::size_t{plan_with("on", "1")->run.kernel->lanes} - 1;
        std::vector<RayInput> incoherent = rays(count), coherent;
        for (std::size_t k = 0; k < count; ++k)
            coherent.push_back({{-0.9, 0.3, 0.1}, {1, 1.8 * double(k) / double(count) - 0.9, 0.2}});
        for (const auto* list : {&incoherent, &coherent})
            EXPECT_NE(occupancy(*list, "on", "0.05"), occupancy(*list, "off", "0.05"));
        EXPECT_EQ(occupancy(incoherent, "auto", "0.05"), occupancy(incoherent, "on", "0.05"));
        EXPECT_EQ(occupancy(incoherent, "auto", "1"), occupancy(incoherent, "off", "1"));
        EXPECT_EQ(occupancy(coherent, "auto", "0.05"), occupancy(coherent, "off", "0.05"));
    }
}

/// Returns rays from one point through 64 × 64 points of a square, row by row.
std::vector<RayInput> rays_through_a_square() {
    std::vector<RayInput> list;
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
            list.push_back({{0.22, -0.92, 0.16}, {-0.22 + x / 32.0 - 1, 0.92, -0.16 + y / 32.0 - 1}});
    return list;
}

/// Returns a random permutation of 0, …, n − 1.
std::vector<std::size_t> random_order(std::size_t n) {
    std::vector<std::size_t> order(n);
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::shuffle(order.begin(), order.end(), std::mt19937(7));
    return order;
}
template <class Ray>
std::vector<Ray> permuted(const std::vector<Ray>& rays, const std::vector<std::size_t>& order) {
    std::vector<Ray> all;
    for (const std::size_t i : order) all.push_back(rays[i]);
    return all;
}

const Overrides collocation{"integrator.method=gauss8", "integrator.step=0.5"};

TEST(OrderOfRays, DoesNotChangeResults) {
    const std::vector<RayInput> ordered = rays_through_a_square();
    const std::vector<std::size_t> order = random_order(ordered.size());
    const std::vector<RayInput> shuffled = permuted(ordered, order);
    const auto plan = room("off", collocation, "packet", false);
    std::vector<RayEnd> ends, expected;
    trace(*plan, start_rays(*plan, shuffled), ends);
    trace(*plan, start_rays(*plan, ordered), expected);
    for (std::size_t i = 0; i < order.size(); ++i) expect_same(ends[i], expected[order[i]]);
    const auto points = trace_paths(*plan, start_rays(*plan, shuffled), ends);
    ASSERT_FALSE(points.empty());
    for (const PathPoint& point : points) {
        if (point.step > 0) continue;
        const Double3& d = shuffled[point.ray].direction;
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(point.v[k], d[k] / std::hypot(d[0], d[1], d[2]), 1e-12);
    }
}

/// Returns the lane-steps that were issued for lanes without an active ray.
double idle_lane_steps(const Counters& counters) {
    return double(counters.issued_lane_steps - counters.active_lane_steps);
}

/// Returns the idle lane-steps for packets of consecutive rays of the list. The kernel is called directly, because
/// `trace` sorts the list.
double idle_lane_steps_as_listed(const Plan& plan, const std::vector<RayStart>& starts) {
    Job job = plan.job();
    job.camera = nullptr;
    job.rays = starts.data();
    job.refill = false;
    std::vector<RayEnd> ends(starts.size());
    Counters counters{};
    const Tile all{0, 0, static_cast<std::uint32_t>(starts.size()), 1};
    plan.run.kernel->trace(&job, &all, ends.data(), &counters);
    return idle_lane_steps(counters);
}

// `trace` sorts a shuffled list, so that neighbouring rays share a packet. The idle lane-steps are compared with those
// of the same kernel for packets of random rays and for packets of consecutive rays of a row.
TEST(OrderOfRays, HardlyChangesOccupancy) {
    for (const std::string& isa : supported_isas())
        for (const char* precision : {"double", "float"})
            for (const char* lanes : {"\"auto\"", "128"}) {
                Options options = with_strategy("packet");
                options.isa = isa;
                options.precision = precision_named(precision);
                Overrides overrides = collocation;
                overrides.insert(overrides.end(), {"integrator.refill=off", std::string("integrator.lanes=") + lanes});
                const auto plan = plan_of_file(scene_file("room.toml"), overrides, options, false);
                SCOPED_TRACE(isa + ", " + precision + ", " + std::to_string(plan->run.kernel->lanes) + " lanes");
                const std::vector<RayStart> rows = start_rays(*plan, rays_through_a_square()),
                                            shuffled = permuted(rows, random_order(rows.size()));
                std::vector<RayEnd> ends;
                const double sorted = idle_lane_steps(trace(*plan, shuffled, ends).counters);
                EXPECT_LT(sorted, 0.5 * idle_lane_steps_as_listed(*plan, shuffled));
                // Packets of a row are long and narrow. Sorting along a Morton curve makes packets that are nearly
                // square.
                EXPECT_LT(sorted, 1.25 * idle_lane_steps_as_listed(*plan, rows));
            }
}

TEST(Refill, ChangesNoPicture) {
    const auto picture = [](const char* refill) {
        const auto plan = room(refill, {}, "packet", true);
        Film film(plan->description().film.width, plan->description().film.height,
                  {"color", "steps", "status", "gradients"});
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
