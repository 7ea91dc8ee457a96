// Tests of the compiled programs of random formulas. Values and gradients that the interpreter computes from these
// programs are compared with dual numbers that are propagated through the nodes of the formula.
#include "kernels/formula/interpreter.h"
#include "kernels/formula/programs.h"
#include "kernels/trace/packets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

namespace kagero::test {
namespace {

/// A value with its derivatives with respect to position and momentum.
using DualDouble = Dual<double, 6>;

/// Returns the result of an operation. Operations that are not listed here use the definition in operation_table.h.
DualDouble apply(Op op, const DualDouble& a, const DualDouble& b) {
    switch (op) {
        case Op::add: return a + b;
        case Op::sub: return a - b;
        case Op::mul: return a * b;
        case Op::div: return a / b;
        case Op::neg: return -a;
        case Op::sqrt: return sqrt(a);
        case Op::exp: return exp(a);
        case Op::log: return log(a);
        case Op::sin: return sin(a);
        case Op::cos: return cos(a);
        case Op::tan: return tan(a);
        case Op::tanh: return tanh(a);
        case Op::abs: return max(a, -a);
        case Op::atan2: return atan2(a, b);
        case Op::min: return min(a, b);
        case Op::max: return max(a, b);
        default: return kagero::detail::apply_at_run_time<DualDouble>(op, a, b, b);
    }
}

/// Returns the operations that have a name, which are those that formulas may contain.
std::vector<Op> named_operations() {
    std::vector<Op> all;
    for (int i = 0; i < op_count; ++i)
        if (*operation_infos[i].name) all.push_back(static_cast<Op>(i));
    return all;
}

/// Returns the nodes of a random formula. The first operand of each operation is one of the last six nodes, so that the
/// last node depends on most of the others.
std::vector<FormulaNode> random_nodes(std::mt19937& random, int operations) {
    static const std::vector<Op> named = named_operations();
    std::vector<FormulaNode> nodes;
    for (int i = 0; i < state_size; ++i) nodes.push_back({Op::input, i, -1, 0});
    for (const double x : {0.5, -1.0, 2.0, 0.0, 1.0, 3.7}) nodes.push_back({Op::constant, -1, -1, x});
    std::uniform_int_distribution<std::size_t> any_op(0, named.size() - 1);
    for (int i = 0; i < operations; ++i) {
        const int size = static_cast<int>(nodes.size());
        std::uniform_int_distribution<int> any_node(0, size - 1), recent_node(std::max(0, size - 6), size - 1);
        const Op op = i % 3 == 0 ? named[any_op(random)] : i % 2 ? Op::mul : Op::add;
        nodes.push_back({op, recent_node(random), info_of(op).operands == 2 ? any_node(random) : -1, 0});
    }
    return nodes;
}

/// Returns the values and derivatives of all nodes at the given position, momentum and p_t.
std::vector<DualDouble> values_of(const std::vector<FormulaNode>& nodes, const double (&at)[7]) {
    std::vector<DualDouble> values;
    for (const FormulaNode& n : nodes) {
        if (n.op == Op::constant) values.emplace_back(n.value);
        else if (n.op == Op::input && n.a < 6) values.push_back(DualDouble::variable(at[n.a], n.a));
        else if (n.op == Op::input) values.push_back(DualDouble(at[n.a]));
        else values.push_back(apply(n.op, values[n.a], n.b < 0 ? DualDouble(0.0) : values[n.b]));
    }
    return values;
}

/// Returns true if the values and derivatives of all nodes are below 1e4, and no node is near a point where its
/// operation is not smooth. The rounding errors of the result are then small.
bool is_well_conditioned(const std::vector<FormulaNode>& nodes, const std::vector<DualDouble>& values) {
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const DualDouble& v = values[i];
        if (nodes[i].op == Op::atan2 && std::abs(values[nodes[i].a].value) < 1e-3) return false;
        const bool has_kink = nodes[i].op == Op::min || nodes[i].op == Op::max;
        if (has_kink && std::abs(values[nodes[i].a].value - values[nodes[i].b].value) < 1e-3) return false;
        if (nodes[i].op == Op::abs && std::abs(v.value) < 1e-3) return false;
        if (!(std::abs(v.value) < 1e4)) return false;
        for (const double d : v.derivative)
            if (!(std::abs(d) < 1e4)) return false;
    }
    return true;
}

// If the operands are equal, the derivative is that of the first operand, as with dual numbers. Inputs 0 and 1 are
// equal, and so are inputs 3 and 4. The operand of `abs` is input 2 or 5, which are 0.
TEST(FormulaPrograms, MinMaxAndAbsOfEqualOperandsHaveTheDerivativeOfTheFirst) {
    const auto programs = std::make_unique<formula::Programs>();
    const double at[7] = {0.5, 0.5, 0, 0.25, 0.25, 0, 1};
    for (const Op op : {Op::min, Op::max, Op::abs})
        for (const int first_operand : {0, 1, 3, 4}) {
            std::vector<FormulaNode> nodes;
            for (int i = 0; i < 7; ++i) nodes.push_back({Op::input, i, -1, 0});
            if (op == Op::abs) nodes.push_back({op, first_operand < 3 ? 2 : 5, -1, 0});
            else nodes.push_back({op, first_operand, first_operand < 3 ? 1 - first_operand : 7 - first_operand, 0});
            const auto values = values_of(nodes, at);
            const Formula f{nodes.data(), 8, 7, -1, -1, -1, -1, {-1, -1}, 0, at[6]};
            ASSERT_EQ(formula::compile(f, nullptr, *programs), nullptr);
            double gradient[6];
            formula::evaluate(programs->derivatives, at, gradient);
            for (int k = 0; k < 6; ++k)
                EXPECT_EQ(gradient[k], values[7].derivative[k])
                    << static_cast<int>(op) << ' ' << first_operand << ' ' << k;
        }
}

// where(c, a, b) consists of two gates. The branch that is not taken has no value here: √x and log(−x) have none on the
// other side of 0. The program must have the derivatives of the branch that is taken, also those of second order.
TEST(FormulaPrograms, BranchesThatAreNotTakenHaveNoInfluence) {
    const auto programs = std::make_unique<formula::Programs>();
    std::vector<FormulaNode> nodes;
    for (int i = 0; i < 7; ++i) nodes.push_back({Op::input, i, -1, 0});
    const auto append = [&](Op op, int a, int b = -1) {
        nodes.push_back({op, a, b, 0});
        return static_cast<int>(nodes.size()) - 1;
    };
    const int above = append(Op::mul, append(Op::sqrt, 0), append(Op::div, 3, 0)),    // √x px/x
              below = append(Op::mul, append(Op::log, append(Op::neg, 0)), append(Op::mul, 3, 1)),  // log(−x) px y
              first = append(Op::if_positive, 0, above), second = append(Op::unless_positive, 0, below),
              sum = append(Op::add, first, second), outer = append(Op::mul, sum, sum),
              // A branch inside a branch: both are not taken.
              inner = append(Op::unless_positive, 0, append(Op::if_positive, 1, append(Op::div, second, above)));
    append(Op::add, append(Op::add, outer, append(Op::mul, 3, 3)), inner);
    const Formula f{nodes.data(), static_cast<std::uint32_t>(nodes.size()), static_cast<int>(nodes.size()) - 1,
                    -1, -1, -1, -1, {-1, -1}, 0, 1};
    ASSERT_EQ(formula::compile(f, nullptr, *programs), nullptr);
    EXPECT_TRUE(programs->has_kinks);
    using SecondOrder = Dual<DualDouble, 6>;
    for (const double x : {0.5, -0.5}) {
        const double at[7] = {x, 4 * x, 0, 0.75, 0, 0, 1}, y = at[1], p = at[3];
        DualDouble in[7], gradient[6];
        for (int k = 0; k < 7; ++k) in[k] = k < 6 ? DualDouble::variable(at[k], k) : DualDouble(at[k]);
        formula::evaluate(programs->derivatives, in, gradient);
        const SecondOrder q = SecondOrder::variable(DualDouble::variable(x, 0), 0),
                          u = SecondOrder::variable(DualDouble::variable(y, 1), 1),
                          m = SecondOrder::variable(DualDouble::variable(p, 3), 3);
        const SecondOrder taken = x > 0 ? m / sqrt(q) : log(-q) * m * u;
        const SecondOrder expected = taken * taken + m * m;
        for (int i = 0; i < 6; ++i) {
            EXPECT_NEAR(gradient[i].value, expected.derivative[i].value, 1e-13) << i;
            for (int k = 0; k < 6; ++k)
                EXPECT_NEAR(gradient[i].derivative[k], expected.derivative[i].derivative[k], 1e-12) << i << ' ' << k;
        }
    }
}

TEST(FormulaPrograms, ValuesAndGradientsMatchDualNumbers) {
    std::mt19937 random(2003);
    std::uniform_real_distribution<double> coordinate(-2, 2);
    const auto programs = std::make_unique<formula::Programs>();
    int compared = 0;
    for (int i = 0; i < 4000; ++i) {
        const auto nodes = random_nodes(random, 4 + i % 40);
        const int last_node = static_cast<int>(nodes.size()) - 1;
        double at[7];
        for (double& x : at) x = coordinate(random);
        const auto values = values_of(nodes, at);
        if (!is_well_conditioned(nodes, values)) continue;
        const auto count = static_cast<std::uint32_t>(nodes.size());
        const Formula f{nodes.data(), count, last_node, -1, -1, -1, -1, {-1, -1}, 0.25, at[6]};
        ASSERT_EQ(formula::compile(f, nullptr, *programs), nullptr);
        double gradient[6], energy[1], force[3], velocity[3];
        formula::evaluate(programs->derivatives, at, gradient);
        formula::evaluate(programs->energy_residual, at, energy);
        formula::evaluate(programs->force, at, force);
        formula::evaluate(programs->velocity, at, velocity);
        PacketDouble in[7], out[6];
        for (int k = 0; k < 7; ++k) in[k] = PacketDouble(at[k]);
        formula::evaluate(programs->derivatives, in, out);
        // The rounding error of 100 operations on numbers up to 1e4 is 1e-10. The formula may amplify it.
        const double rounding = 1e-8;
        ASSERT_NEAR(energy[0], values[last_node].value - 0.25, rounding) << i;
        for (int k = 0; k < 6; ++k) {
            ASSERT_NEAR(gradient[k], values[last_node].derivative[k], rounding) << i << ' ' << k;
            ASSERT_NEAR(k < 3 ? force[k] : velocity[k - 3], gradient[k], rounding) << i << ' ' << k;
            ASSERT_NEAR(get_lane(out[k], lane_count<PacketDouble> - 1), gradient[k], rounding) << i << ' ' << k;
        }
        ++compared;
    }
    EXPECT_GT(compared, 1000);
}

// The formula has as many nodes as are permitted, but its programs exceed the capacity of a tape.
TEST(FormulaPrograms, TooLargeFormulasAreRefused) {
    std::mt19937 random(1);
    const auto nodes = random_nodes(random, 4000);
    std::vector<FormulaNode> sum = nodes;
    for (int i = 7; i < 4000 && sum.size() < max_formula_nodes; ++i)
        sum.push_back({Op::add, static_cast<int>(sum.size()) - 1, i, 0});
    const auto count = static_cast<std::uint32_t>(sum.size());
    const Formula f{sum.data(), count, static_cast<int>(count) - 1, -1, -1, -1, -1, {-1, -1}, 0, 0};
    const auto programs = std::make_unique<formula::Programs>();
    EXPECT_NE(formula::compile(f, nullptr, *programs), nullptr);
}

}  // namespace
}  // namespace kagero::test
