// What the table says of a method is so, and what it does not say is not: symmetric methods go back the way they came,
// symplectic ones keep the volume element dq ∧ dp.
#include "tests/kernels/steps.h"

#include "kernels/trace/packets.h"

#include <algorithm>

namespace kagero::test {
namespace {

template <class H>
class Structure : public ::testing::Test {};
TYPED_TEST_SUITE(Structure, AllHamiltonians, HamiltonianName);

template <class H>
constexpr double step_length = path_length<H> / 16;

/// Every method is exact on straight rays, and from order 2 on parabolas.
bool is_exact(const Method& method, Motion motion) {
    return motion == Motion::straight || (motion == Motion::uniform && method.info.order > 1);
}

/// Greatest component by which n steps forward and n back, in the last lane, miss the start, relative to the state.
template <class H, class V>
double return_defect(const Method& method, bool rescaled, int n) {
    using S = ScalarOf<V>;
    auto there = Steps<V>::template in<H>(method, rescaled), back = there;
    const State<V> start = state_of<V>(bent_ray<H>());
    there.begin(start, V(S(step_length<H>)));
    there.advance(n);
    back.begin(there.flow.end, V(S(-step_length<H>)));
    back.advance(n);
    EXPECT_TRUE(to_bits(there.flow.solved) & to_bits(back.flow.solved) & 1);
    double defect = 0, size = 1;
    const auto at = [](const V& v) { return get_lane(v, lane_count<V> - 1); };
    for (int k = 0; k < 6; ++k) {
        const double off = std::abs(static_cast<double>(at(back.flow.end.y[k]) - at(start.y[k])));
        EXPECT_TRUE(std::isfinite(off));
        defect = std::max(defect, off);
        size = std::max(size, std::abs(static_cast<double>(at(there.flow.end.y[k]))));
    }
    return defect / size;
}

template <class H, class V>
void expect_return() {
    constexpr int n = 10;
    const Motion motion = motion_in<H>();
    for_all_methods<H>([&](const Method& method, bool rescaled) {
        // Some roundings in each stage of each step, stretched by a flow that stretches little on so short a path.
        const double roundings = 100 * n * stages_of(method),
                     epsilon = static_cast<double>(machine_epsilon<ScalarOf<V>>);
        const double defect = return_defect<H, V>(method, rescaled, n);
        if (symmetric_on<H>(method) && mirrored(method)) {
            EXPECT_LE(defect, roundings * epsilon);
        } else if (method.info.symmetric || is_exact(method, motion)) {
            EXPECT_LE(defect, roundings * coefficient_epsilon<ScalarOf<V>>(method));
        } else if (std::is_same_v<V, Quad> &&
                   !method.info.angular) {  // where nothing shortens it a step about a centre is symmetric
            EXPECT_GT(defect, 1e6 * roundings * epsilon) << "symmetric after all?";
        }
    });
}
TYPED_TEST(Structure, ForwardThenBackInQuadruplePrecision) { expect_return<TypeParam, Quad>(); }
TYPED_TEST(Structure, ForwardThenBackInDouble) { expect_return<TypeParam, double>(); }
TYPED_TEST(Structure, ForwardThenBackInPacketsOfDouble) { expect_return<TypeParam, PacketDouble>(); }
TYPED_TEST(Structure, ForwardThenBackInPacketsOfFloat) { expect_return<TypeParam, PacketFloat>(); }

template <class S>
using Jacobian = std::array<std::array<S, 6>, 6>;

/// M = ∂(end)/∂(start) of one step by central differences of fourth order with distance d, each lane the same.
template <class H, class V>
Jacobian<ScalarOf<V>> jacobian(const Method& method, bool rescaled, ScalarOf<V> d) {
    using S = ScalarOf<V>;
    auto steps = Steps<V>::template in<H>(method, rescaled);
    const State<V> start = state_of<V>(bent_ray<H>());
    Jacobian<S> m{};
    for (int column = 0; column < 6; ++column) {
        for (const int shift : {-2, -1, 1, 2}) {
            State<V> moved = start;
            moved.y[column] = moved.y[column] + V(d * S(shift));
            steps.begin(moved, V(S(step_length<H>)));
            steps.step();
            const S weight = S(shift == -2 ? 1 : shift == -1 ? -8 : shift == 1 ? 8 : -1) / (12 * d);
            for (int row = 0; row < 6; ++row)
                m[row][column] += weight * get_lane(steps.flow.end.y[row], lane_count<V> - 1);
        }
    }
    return m;
}

/// Greatest component of Mᵀ J M − J, relative to the square of M's.
template <class S>
double symplectic_defect(const Jacobian<S>& m) {
    S defect = 0, size = 0;
    for (int i = 0; i < 6; ++i) {
        for (int k = 0; k < 6; ++k) {
            S sum = i + 3 == k ? S(-1) : i == k + 3 ? S(1) : S(0);
            for (int a = 0; a < 3; ++a) sum += m[a][i] * m[a + 3][k] - m[a + 3][i] * m[a][k];
            defect = max(defect, abs(sum)), size = max(size, abs(m[i][k]));
        }
    }
    return static_cast<double>(defect / (size * size));
}

/// Differences at a distance ε^(1/5) of the space's scale lose ε^(4/5) to rounding and as much, times a fifth
/// derivative, to their formula.
template <class H, class V>
void expect_symplectic() {
    using S = ScalarOf<V>;
    const double epsilon = static_cast<double>(machine_epsilon<S>),
                 distance = std::min(1.0, path_length<H>) * std::pow(epsilon, 0.2);
    const double tolerance = 1000 * std::pow(epsilon, 0.8);
    const Motion motion = motion_in<H>();
    for_all_methods<H>([&](const Method& method, bool rescaled) {
        const double defect = symplectic_defect(jacobian<H, V>(method, rescaled, S(distance)));
        if (method.info.symplectic || is_exact(method, motion)) {
            EXPECT_LE(defect, tolerance);
        } else if (std::is_same_v<V, Quad>) {
            EXPECT_GT(defect, 1e3 * tolerance) << "symplectic after all?";
        }
    });
}
TYPED_TEST(Structure, SymplecticInQuadruplePrecision) { expect_symplectic<TypeParam, Quad>(); }
TYPED_TEST(Structure, SymplecticInDouble) { expect_symplectic<TypeParam, double>(); }
TYPED_TEST(Structure, SymplecticInPacketsOfDouble) { expect_symplectic<TypeParam, PacketDouble>(); }

}  // namespace
}  // namespace kagero::test
