// The reverse sweep: its adjoints against differences of rays, its sums against operations counted by hand.
#include "tests/kernels/steps.h"

#include "kernels/adjoint/rounding.h"
#include "kernels/adjoint/sweep.h"
#include "kernels/trace/packets.h"

#include <numbers>
#include <string_view>

namespace kagero::test {
namespace {

using V = PacketDouble;
constexpr int last_lane = lane_count<V> - 1;

struct Path {
    std::vector<State<V>> states;
    std::vector<V> parameters;
    Vec3<V> velocity{};  ///< at the end, of any length
};

/// Where y and z lie at the end, on the plane through the end with this normal.
Sight<V> view_on(const Vec3<V>& normal) {
    const V zero(0.0), one(1.0);
    return {normal, {{zero, one, zero}, {zero, zero, one}}, {{zero, zero, zero}, {zero, zero, zero}}};
}

/// Rows at the start of a path, from the last lane.
std::array<std::array<double, 6>, 2> rows_at_start(const SpaceKernel<V>& kernel, const double* parameters,
                                                   const Path& path, const Sight<V>& view) {
    SystemStorage system;
    kernel.construct(system, parameters);
    const SweptSystem<V> swept{kernel, system};
    const RoundingCounts counts{};
    Sweep<V> sweep;
    sweep.state = path.states.back();
    begin_sweep(swept, view, sweep);
    for (std::size_t i = path.states.size() - 1; i-- > 0;)
        sweep_step(swept, path.states[i], path.parameters[i + 1] - path.parameters[i], counts, sweep);
    std::array<std::array<double, 6>, 2> rows;
    for (int r = 0; r < 2; ++r)
        for (int k = 0; k < 6; ++k) rows[r][k] = get_lane(sweep.rows[r][k], last_lane);
    return rows;
}

template <class H>
Path path_from(const State<V>& start, bool rescaled, int steps) {
    auto walk = Steps<V>::template in<H>(method_named("gauss8"), rescaled);
    walk.begin(start, V(path_length<H> / steps));
    Path path{{start}, {V(0.0)}};
    for (int i = 0; i < steps; ++i) {
        walk.advance(1);
        path.states.push_back(walk.flow.end), path.parameters.push_back(walk.flow.end.parameter);
    }
    path.velocity = walk.flow.end.velocity;
    return path;
}

/// By how much the rows at the start, of `steps` steps, differ from differences of neighbouring rays, relative to the
/// greatest.
template <class H>
double defect(bool rescaled, int steps) {
    const State<V> start = state_of<V>(bent_ray<H>(0, true));
    const Path path = path_from<H>(start, rescaled, steps);
    const Vec3<V> velocity = path.velocity;
    const auto rows =
        rows_at_start(space_kernel<H, V>(rescaled), default_parameters<H>().data(), path, view_on(velocity));
    const auto moved = [&](int k, double by) {
        State<V> aside = start;
        aside.y[k] = aside.y[k] + V(by);
        Vec3<V> q = path_from<H>(aside, rescaled, steps).states.back().q();
        const Vec3<V> way = retreat(q, V(1.0), path.states.back().q());
        q = retreat(q, dot(way, velocity) / dot(velocity, velocity), velocity);
        return std::array{get_lane(q.y, last_lane), get_lane(q.z, last_lane)};
    };
    double worst = 0, greatest = 0;
    for (int k = 0; k < 6; ++k) {
        constexpr double by = 1e-5;
        const auto more = moved(k, by), less = moved(k, -by);
        for (int r = 0; r < 2; ++r) {
            const double slope = (more[r] - less[r]) / (2 * by);
            EXPECT_TRUE(std::isfinite(rows[r][k]) && std::isfinite(slope));
            worst = std::max(worst, std::abs(rows[r][k] - slope)), greatest = std::max(greatest, std::abs(slope));
        }
    }
    return worst / greatest;
}

template <class H>
class Adjoints : public ::testing::Test {};
TYPED_TEST_SUITE(Adjoints, AllHamiltonians, HamiltonianName);

// Of the fourth order; what differences of rays cannot tell apart is left.
TYPED_TEST(Adjoints, AreDifferencesOfRays) {
    using H = TypeParam;
    for (const bool rescaled : rescalings<H>()) {
        const double coarse = defect<H>(rescaled, 32), fine = defect<H>(rescaled, 128);
        EXPECT_LE(fine, std::max(0.02 * coarse, 1e-7)) << (rescaled ? "rescaled" : "");
        EXPECT_LE(fine, 1e-4);
    }
}

// Parallel light meets in a point of a Luneburg lens: there y and z are those of p, wherever the light has entered.
TYPED_TEST(Adjoints, PassSurfacesWhereHIsNotSmooth) {
    using H = TypeParam;
    if constexpr (std::string_view(H::name) != "luneburg") {
        GTEST_SKIP() << "H is smooth";
    } else {
        constexpr double y = 0.6, x = -0.8, before = 1.2;
        constexpr int inside = 16;
        const auto state = [](double qx, double qy, double px, double py) {
            return State<V>{{V(qx), V(qy), V(0.0), V(px), V(py), V(0.0), V(0.0)}};
        };
        Path path{{state(x - before, y, 1, 0), state(x, y, 1, 0)}, {V(0.0), V(before)}};
        for (int i = 1; i <= inside; ++i) {
            const double t = std::numbers::pi / 2 * i / inside, c = std::cos(t), s = std::sin(t);
            path.states.push_back(state(x * c + s, y * c, c - x * s, -y * s)), path.parameters.push_back(V(before + t));
        }
        const auto rows = rows_at_start(space_kernel<H, V>(false), default_parameters<H>().data(), path,
                                        view_on({V(1.0), V(0.0), V(0.0)}));
        const double expected[2][6] = {{0, 0, 0, -y / x, 1, 0}, {0, 0, 0, 0, 0, 1}};
        for (int r = 0; r < 2; ++r)
            for (int k = 0; k < 6; ++k) EXPECT_NEAR(rows[r][k], expected[r][k], 1e-5) << r << k;
    }
}

// 1/(x y), a product of 20, the first place of which is 16, and a reciprocal of 1/20 with its 1/32, which counts four
// times.
TEST(Roundings, AreThoseOfEveryOperation) {
    Tape t;
    const int x = t.input(0), y = t.input(1);
    const auto program = kagero::detail::extract_all<1>(t, std::array{t.recip(t.mul(x, y))});
    const double inputs[] = {4, 5}, seeds[] = {0.6, 0.8};
    const double sum = sum_of_roundings<double>(
        Listed<double>{{program.nodes, program.slot, program.outputs.data(), program.size}, nullptr}, inputs, seeds, 1);
    EXPECT_NEAR(sum, 4 / 32.0 + 16 / 400.0, 1e-12);
}

// x y − 19 = 1, with the 16 of the product where that is rounded apart.
TEST(Roundings, CountProductsThatAreNotFused) {
    Tape t;
    const auto program =
        kagero::detail::extract_all<1>(t, std::array{t.sub(t.mul(t.input(0), t.input(1)), t.input(2))});
    const double inputs[] = {4, 5, 19}, seeds[] = {0.6, 0.8};
    const double sum = sum_of_roundings<double>(
        Listed<double>{{program.nodes, program.slot, program.outputs.data(), program.size}, nullptr}, inputs, seeds, 1);
#if defined(__FMA__)
    EXPECT_EQ(sum, 1);
#else
    EXPECT_EQ(sum, 1 + 16);
#endif
}

}  // namespace
}  // namespace kagero::test
