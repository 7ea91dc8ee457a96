// Tests the symmetry and symplecticity of all methods. A method must be symmetric or symplectic if and only if the
// table of methods states it. Symmetric methods return to the start after equal numbers of steps forward and backward.
// Symplectic methods preserve the 2-form dq ∧ dp.
#include "tests/kernels/steps.h"

#include "kernels/trace/packets.h"

#include <algorithm>

namespace kagero::test {
namespace {

template <class H>
class StructurePreservation : public ::testing::Test {};
TYPED_TEST_SUITE(StructurePreservation, AllHamiltonians, HamiltonianName);

template <class H>
constexpr double step_length = path_length<H> / 16;

/// Returns true if the method is exact in a motion. All methods are exact on straight rays. Methods of order 2 and
/// above are also exact with constant force.
bool is_exact(const Method& method, Motion motion) {
    return motion == Motion::straight || (motion == Motion::uniform && method.info.order > 1);
}

/// Returns the greatest difference of a component from the start after n steps forward and n steps backward, in the
/// last lane. It is relative to the greatest component of the state.
template <class H, class V>
double return_defect(const Method& method, bool rescaled, int n) {
    using S = ScalarOf<V>;
    auto forward = SpaceStepper<V>::template for_space<H>(method, rescaled), backward = forward;
    const State<V> start = state_of<V>(bent_ray<H>());
    forward.begin(start, V(S(step_length<H>)));
    forward.advance(n);
    backward.begin(forward.state.end, V(S(-step_length<H>)));
    backward.advance(n);
    EXPECT_TRUE(to_bits(forward.state.solved) & to_bits(backward.state.solved) & 1);
    double defect = 0, size = 1;
    const auto at = [](const V& v) { return get_lane(v, lane_count<V> - 1); };
    for (int k = 0; k < 6; ++k) {
        const double difference = std::abs(static_cast<double>(at(backward.state.end.y[k]) - at(start.y[k])));
        EXPECT_TRUE(std::isfinite(difference));
        defect = std::max(defect, difference);
        size = std::max(size, std::abs(static_cast<double>(at(forward.state.end.y[k]))));
    }
    return defect / size;
}

template <class H, class V>
void expect_symmetry_as_stated() {
    constexpr int n = 10;
    const Motion motion = motion_in<H>();
    for_all_methods<H>([&](const Method& method, bool rescaled) {
        // The tolerance is 100 rounding errors per stage. The flow amplifies rounding errors little on this short path.
        const double roundings = 100 * n * stages_of(method),
                     epsilon = static_cast<double>(machine_epsilon<ScalarOf<V>>);
        const double defect = return_defect<H, V>(method, rescaled, n);
        if (symmetric_in<H>(method) && has_palindromic_fractions(method)) {
            EXPECT_LE(defect, roundings * epsilon);
        } else if (method.info.symmetric || is_exact(method, motion)) {
            EXPECT_LE(defect, roundings * coefficient_epsilon<ScalarOf<V>>(method));
        } else if (std::is_same_v<V, Quad> && !method.info.angular) {
            // Angular methods are left out: the table states no symmetry for them, because they are symmetric only as
            // long as no step is shortened.
            EXPECT_GT(defect, 1e6 * roundings * epsilon)
                << "The method is symmetric, although the table does not state it.";
        }
    });
}
TYPED_TEST(StructurePreservation, SymmetryIsAsStatedInQuadruplePrecision) {
    expect_symmetry_as_stated<TypeParam, Quad>();
}
TYPED_TEST(StructurePreservation, SymmetryIsAsStatedInDouble) {
    expect_symmetry_as_stated<TypeParam, double>();
}
TYPED_TEST(StructurePreservation, SymmetryIsAsStatedInPacketsOfDouble) {
    expect_symmetry_as_stated<TypeParam, PacketDouble>();
}
TYPED_TEST(StructurePreservation, SymmetryIsAsStatedInPacketsOfFloat) {
    expect_symmetry_as_stated<TypeParam, PacketFloat>();
}

template <class S>
using Jacobian = std::array<std::array<S, 6>, 6>;

/// Returns M = ∂(end)/∂(start) of one step by central differences of order 4 with spacing d, in the last lane.
template <class H, class V>
Jacobian<ScalarOf<V>> jacobian(const Method& method, bool rescaled, ScalarOf<V> d) {
    using S = ScalarOf<V>;
    auto stepper = SpaceStepper<V>::template for_space<H>(method, rescaled);
    const State<V> start = state_of<V>(bent_ray<H>());
    Jacobian<S> m{};
    for (int column = 0; column < 6; ++column) {
        for (const int shift : {-2, -1, 1, 2}) {
            State<V> shifted = start;
            shifted.y[column] = shifted.y[column] + V(d * S(shift));
            stepper.begin(shifted, V(S(step_length<H>)));
            stepper.step();
            const S weight = S(shift == -2 ? 1 : shift == -1 ? -8 : shift == 1 ? 8 : -1) / (12 * d);
            for (int row = 0; row < 6; ++row)
                m[row][column] += weight * get_lane(stepper.state.end.y[row], lane_count<V> - 1);
        }
    }
    return m;
}

/// Returns the greatest component of Mᵀ J M − J, relative to the square of the greatest component of M. J is the matrix
/// of the symplectic form.
template <class S>
double symplectic_defect(const Jacobian<S>& m) {
    S defect = 0, size = 0;
    for (int i = 0; i < 6; ++i) {
        for (int k = 0; k < 6; ++k) {
            S sum = i + 3 == k ? S(-1) : i == k + 3 ? S(1) : S(0);
            for (int a = 0; a < 3; ++a) sum += m[a][i] * m[a + 3][k] - m[a + 3][i] * m[a][k];
            defect = max(defect, abs(sum));
            size = max(size, abs(m[i][k]));
        }
    }
    return static_cast<double>(defect / (size * size));
}

/// The spacing of the differences is ε^(1/5) times the length scale of the space. Their rounding error is then about
/// ε^(4/5), and their truncation error is about ε^(4/5) times a fifth derivative.
template <class H, class V>
void expect_symplecticity_as_stated() {
    using S = ScalarOf<V>;
    const double epsilon = static_cast<double>(machine_epsilon<S>),
                 spacing = std::min(1.0, path_length<H>) * std::pow(epsilon, 0.2);
    const double tolerance = 1000 * std::pow(epsilon, 0.8);
    const Motion motion = motion_in<H>();
    for_all_methods<H>([&](const Method& method, bool rescaled) {
        const double defect = symplectic_defect(jacobian<H, V>(method, rescaled, S(spacing)));
        if (method.info.symplectic || is_exact(method, motion)) {
            EXPECT_LE(defect, tolerance);
        } else if (std::is_same_v<V, Quad>) {
            EXPECT_GT(defect, 1e3 * tolerance) << "The method is symplectic, although the table does not state it.";
        }
    });
}
TYPED_TEST(StructurePreservation, SymplecticityIsAsStatedInQuadruplePrecision) {
    expect_symplecticity_as_stated<TypeParam, Quad>();
}
TYPED_TEST(StructurePreservation, SymplecticityIsAsStatedInDouble) {
    expect_symplecticity_as_stated<TypeParam, double>();
}
TYPED_TEST(StructurePreservation, SymplecticityIsAsStatedInPacketsOfDouble) {
    expect_symplecticity_as_stated<TypeParam, PacketDouble>();
}

}  // namespace
}  // namespace kagero::test
