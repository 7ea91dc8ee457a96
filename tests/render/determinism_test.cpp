// Tests that a picture depends only on scene, options and instruction set, and not on the distribution of the work.
#include "tests/support/plan_fixture.h"
#include "tests/support/program.h"

#include <algorithm>
#include <cmath>

namespace kagero::test {
namespace {

const Overrides overrides{"film.size=[100,80]",
                          "film.layers=[\"color\",\"status\",\"steps\",\"energy_error\",\"object\",\"depth\","
                          "\"newton\",\"position_error\",\"rounding_error\"]"};

constexpr const char* layers[] = {"color", "status", "steps",          "energy_error",  "object",
                                  "depth", "newton", "position_error", "rounding_error"};

/// Returns true if a and b are equal or both NaN.
bool equal_or_both_nan(float a, float b) {
    return a == b || (std::isnan(a) && std::isnan(b));
}

/// Returns the plan of the scene room. `method` contains the overrides that select a method. Without them, the method
/// is the default method of the scene, which is explicit.
std::unique_ptr<Plan> room(const Options& options, const Overrides& method = {}) {
    Overrides with_method = overrides;
    with_method.insert(with_method.end(), method.begin(), method.end());
    return plan_of_file(KAGERO_SCENES "/room.toml", with_method, options);
}
/// Overrides that select an explicit method and two implicit methods. The equations of the implicit methods are solved
/// by fixed-point iteration, and by Newton's method if the iteration fails.
const Overrides methods[] = {{},
                             {"integrator.method=verlet", "integrator.step=0.8"},
                             {"integrator.method=gauss8", "integrator.step=0.5"}};

class Determinism : public ProgramTest {
protected:
    /// Returns the bytes of the OpenEXR file of a film.
    std::string exr(const std::string& name, const Film& film) const {
        const std::string path = (directory_ / name).string();
        write_film(film, path, {});
        return text_of(path);
    }
};

TEST_F(Determinism, HoldsForAnyNumberOfThreads) {
    std::string expected_bytes;
    for (const unsigned threads : {1u, 2u, 5u}) {
        Options options;
        options.threads = threads;
        const auto plan = room(options);
        Film film(100, 80, plan->description().film.layers);
        render_with_errors(*plan, film);
        const std::string bytes = exr("room.exr", film);
        if (expected_bytes.empty()) expected_bytes = bytes;
        EXPECT_EQ(bytes == expected_bytes, true) << threads << " threads";
    }
}

TEST_F(Determinism, HoldsForTheFilesOfTheProgram) {
    std::string expected_bytes;
    for (const char* threads : {"1", "2", "5"}) {
        const Outcome outcome =
            run("render '" KAGERO_SCENES
                "/room.toml' --size 100x80 --layers color,steps,status -o a.exr --quiet --threads " +
                std::string(threads));
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        if (expected_bytes.empty()) expected_bytes = read("a.exr");
        EXPECT_EQ(read("a.exr") == expected_bytes, true) << threads << " threads";
    }
    EXPECT_EQ(files(), (std::set<std::string>{"a.exr"}));
}

TEST_F(Determinism, HoldsForEverySchedule) {
    std::string expected_bytes;
    for (const std::string& schedule : schedule_names())
        for (const unsigned threads : {1u, 3u}) {
            Options options;
            options.threads = threads;
            options.schedule = schedule_named(schedule);
            const auto plan = room(options);
            Film film(100, 80, plan->description().film.layers);
            const RunReport report = render_with_errors(*plan, film);
            EXPECT_EQ(name_of(report.schedule), schedule);
            EXPECT_EQ(report.rays, 100u * 80u);
            EXPECT_EQ(report.threads.size(), threads);
            const std::string bytes = exr("room.exr", film);
            if (expected_bytes.empty()) expected_bytes = bytes;
            EXPECT_EQ(bytes == expected_bytes, true) << schedule << ", " << threads << " threads";
        }
}

TEST_F(Determinism, HoldsForCrops) {
    for (const Overrides& method : methods) {
        const auto plan = room(with_strategy("packet"), method);
        Film whole(100, 80, plan->description().film.layers);
        render_with_errors(*plan, whole);
        for (const Tile& crop : {Tile{0, 0, 100, 80}, Tile{13, 7, 71, 41}, Tile{99, 79, 100, 80}, Tile{31, 0, 33, 80},
                                 Tile{50, 40, 51, 41}}) {
            Options options = with_strategy("packet");
            options.crop = crop;
            const auto part = room(options, method);
            const auto [x0, y0, x1, y1] = crop;
            Film film(x1 - x0, y1 - y0, part->description().film.layers);
            render_with_errors(*part, film);
            for (const char* layer : layers)
                for (std::uint32_t y = y0; y < y1; ++y)
                    for (std::uint32_t x = x0; x < x1; ++x)
                        ASSERT_PRED2(equal_or_both_nan, *film.pixel(layer, x - x0, y - y0), *whole.pixel(layer, x, y))
                            << layer << " " << x << "," << y;
        }
    }
}

/// Traces rays in packets of consecutive rays of the list. The kernel is called directly, because the function `trace`
/// would sort the list first.
std::vector<RayEnd> traced_in_order(const Plan& plan, const std::vector<RayStart>& starts) {
    Job job = plan.job();
    job.camera = nullptr;
    job.rays = starts.data();
    std::vector<RayEnd> ends(starts.size());
    Counters counters{};
    const Tile all{0, 0, static_cast<std::uint32_t>(starts.size()), 1};
    plan.run.kernel->trace(&job, &all, ends.data(), &counters);
    return ends;
}

// A ray must not depend on the other rays of its packet.
TEST_F(Determinism, HoldsForAnyOrderOfRays) {
    for (const Overrides& method : methods) {
        const auto plan = room(with_strategy("packet"), method);
        std::vector<RayStart> starts;
        for (std::uint32_t i = 0; i < 700; ++i) starts.push_back(pixel_ray_start(*plan, i * 37 % 100, i * 11 % 80));
        const std::vector<RayEnd> ends = traced_in_order(*plan, starts);
        std::rotate(starts.begin(), starts.begin() + 3, starts.end());
        std::reverse(starts.begin() + 100, starts.end());
        std::vector<RayEnd> reordered = traced_in_order(*plan, starts);
        std::reverse(reordered.begin() + 100, reordered.end());
        std::rotate(reordered.begin(), reordered.end() - 3, reordered.end());
        for (std::size_t i = 0; i < ends.size(); ++i) {
            ASSERT_EQ(ends[i].status, reordered[i].status) << i;
            ASSERT_EQ(ends[i].steps, reordered[i].steps) << i;
            ASSERT_EQ(ends[i].gradients, reordered[i].gradients) << i;
            ASSERT_EQ(ends[i].iterations, reordered[i].iterations) << i;
            ASSERT_EQ(ends[i].queries, reordered[i].queries) << i;
            for (int k = 0; k < 3; ++k) ASSERT_EQ(ends[i].q[k], reordered[i].q[k]) << i;
            for (int k = 0; k < 3; ++k) ASSERT_EQ(ends[i].p[k], reordered[i].p[k]) << i;
        }
    }
}

// Scalar and packet code have the same roundings and the same fused multiply-adds. They solve an implicit step with the
// same number of iterations. The ray ends must therefore be equal bit for bit. Only Embree could return different
// results for single rays and for packets.
TEST_F(Determinism, HoldsForScalarAndPacketCode) {
    for (const Overrides& method : methods) {
        const auto packet = room(with_strategy("packet"), method), scalar = room(with_strategy("scalar"), method);
        std::vector<RayStart> starts;
        for (std::uint32_t y = 0; y < 80; ++y)
            for (std::uint32_t x = 0; x < 100; ++x) starts.push_back(pixel_ray_start(*packet, x, y));
        std::vector<RayEnd> a, b;
        trace(*packet, starts, a);
        trace(*scalar, starts, b);
        for (std::size_t i = 0; i < a.size(); ++i) {
            ASSERT_EQ(a[i].status, b[i].status) << i;
            ASSERT_EQ(a[i].surface, b[i].surface) << i;
            ASSERT_EQ(a[i].primitive, b[i].primitive) << i;
            ASSERT_EQ(a[i].steps, b[i].steps) << i;
            ASSERT_EQ(a[i].iterations, b[i].iterations) << i;
            for (int k = 0; k < 3; ++k) ASSERT_EQ(a[i].q[k], b[i].q[k]) << i;
        }
    }
}

}  // namespace
}  // namespace kagero::test
