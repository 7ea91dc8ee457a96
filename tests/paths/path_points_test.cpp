// Points of paths that continue at surfaces: at even intervals of λ, and with the integrals along the path.
#include "tests/support/plan_fixture.h"

#include "error.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kagero::test {
namespace {

/// Returns a scene with two balls of glass, one inside the other.
std::string scene_in(const std::string& space) {
    return "[space]\n" + space + R"(
[integrator]
escape_radius = 12
[[medium]]
name = "glass"
hamiltonian = "uniform"
n0 = 1.5
[[medium]]
name = "core"
hamiltonian = "fiber"
n0 = 2
alpha = 0.3
[camera]
position = [0, -4, 0]
look_at = [0, 0, 0]
up = [0, 0, 1]
[film]
size = [4, 4]
[[object]]
name = "ball"
shape = "sphere"
center = [0, 0, 0]
radius = 1
material = "boundary"
interior = "glass"
[[object]]
name = "core"
shape = "sphere"
center = [0, 0, 0.1]
radius = 0.5
material = "boundary"
interior = "core"
exterior = "glass"
)";
}

const char* const flat = "hamiltonian = \"flat\"";
const char* const hole = "hamiltonian = \"schwarzschild\"\nrg = 0.1\ncenter = [0, 0, 3]";

const std::vector<RayInput> rays{{{0, -4, 0.2}, {0, 1, 0}},
                                 {{0.3, -4, 0}, {0, 1, 0.02}},
                                 {{0, 0.2, 0}, {0, 1, 0.3}},
                                 {{0, -4, 1.5}, {0, 1, 0}}};

class PathPoints : public testing::TestWithParam<std::string> {
protected:
    /// Returns the points of the paths, at the multiples of `interval` or, if it is 0, at every step.
    static std::vector<PathPoint> points_of(const std::string& space, double interval, std::vector<RayEnd>& ends) {
        Options options;
        options.isa = GetParam();
        options.bounces = 6;
        options.parameter = options.action = true;
        options.time = space == hole;
        const auto plan = plan_of_text(scene_in(space), {}, options, false);
        plan->run.path_interval = interval;
        return trace_paths(*plan, start_rays(*plan, rays), ends);
    }
};

INSTANTIATE_TEST_SUITE_P(Isas, PathPoints, testing::ValuesIn(supported_isas()),
                         [](const auto& isa) { return isa.param; });

// λ counts along the whole path. In flat space and in glass, the points lie on the straight lines between surfaces.
TEST_P(PathPoints, AreAtTheMultiplesOfTheIntervalOnTheWholePath) {
    constexpr double interval = 0.17;
    std::vector<RayEnd> ends;
    const std::vector<PathPoint> steps = points_of(flat, 0, ends), points = points_of(flat, interval, ends);
    for (std::size_t ray = 0; ray < rays.size(); ++ray) {
        SCOPED_TRACE(ray);
        std::size_t count = 0;
        for (const PathPoint& point : points) {
            if (point.ray != ray) continue;
            ASSERT_EQ(point.step, count++);
            EXPECT_DOUBLE_EQ(point.parameter, interval * point.step);
            // The step that contains the point: both ends belong to the same segment.
            const auto next = std::find_if(steps.begin(), steps.end(), [&](const PathPoint& each) {
                return each.ray == ray && each.parameter >= point.parameter && each.step > 0;
            });
            ASSERT_NE(next, steps.end());
            const PathPoint &a = *(next - 1), &b = *next;
            ASSERT_EQ(a.segment, b.segment);
            EXPECT_EQ(point.segment, b.segment);
            EXPECT_EQ(point.medium, b.medium);
            if (b.medium == 2) continue;  // rays are bent there
            const double u = (point.parameter - a.parameter) / (b.parameter - a.parameter);
            for (int k = 0; k < 3; ++k) EXPECT_NEAR(point.q[k], a.q[k] + u * (b.q[k] - a.q[k]), 1e-12);
            EXPECT_NEAR(point.action, a.action + u * (b.action - a.action), 1e-12);
        }
        EXPECT_EQ(count, std::size_t(ends[ray].parameter / interval) + 1);
    }
    EXPECT_GE(std::max_element(points.begin(), points.end(),
                               [](const PathPoint& a, const PathPoint& b) { return a.segment < b.segment; })
                  ->segment,
              4u);
}

// H = 0 along a null ray with p_t = 1, so that the action is the time that passes. In a medium, light takes the time of
// the optical path length.
TEST_P(PathPoints, HaveTheTimeThatTheActionImplies) {
    for (const double interval : {0.0, 0.25}) {
        std::vector<RayEnd> ends;
        const std::vector<PathPoint> points = points_of(hole, interval, ends);
        std::size_t in_media = 0;
        for (const PathPoint& point : points) {
            EXPECT_NEAR(point.time, -point.action, 1e-9) << point.ray << ' ' << point.step;
            if (point.medium != 0 && point.action > 0) ++in_media;
        }
        EXPECT_GT(in_media, 6u);
        for (const RayEnd& end : ends) EXPECT_NEAR(end.time, -end.action, 1e-9);
    }
}

TEST(PathInterval, IsRefusedIfItGivesTooManyPoints) {
    const auto plan = plan_of_text(scene_in(flat), {}, {}, false);
    plan->run.path_interval = 1e-12;
    try {
        check_path_points(*plan, start_rays(*plan, rays), rays.size());
        FAIL() << "no error";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("the interval 1e-12 of λ between the points of paths is too short"),
                  std::string::npos)
            << error.what();
    }
}

}  // namespace
}  // namespace kagero::test
