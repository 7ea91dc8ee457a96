// Programs of formulas: whatever the formula, code that is interpreted has the values and the gradient of the formula
// itself.
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

using Forward = Dual<double, 6>;

/// Operations by themselves; those that are not listed here are applied as the table has them.
Forward apply(Op op, const Forward& a, const Forward& b) {
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
        default: return kagero::detail::applied<Forward>(op, a, b, b);
    }
}

/// The operations that formulas have.
std::vector<Op> named_operations() {
    std::vector<Op> all;
    for (int i = 0; i < op_count; ++i)
        if (*operation_infos[i].name) all.push_back(static_cast<Op>(i));
    return all;
}

/// A random list of nodes over all operations; operands are mostly late ones, so that much of it hangs together.
std::vector<FormulaNode> random_nodes(std::mt19937& random, int operations) {
    static const std::vector<Op> named = named_operations();
    std::vector<FormulaNode> nodes;
    for (int i = 0; i < state_size; ++i) nodes.push_back({Op::input, i, -1, 0});
    for (const double x : {0.5, -1.0, 2.0, 0.0, 1.0, 3.7}) nodes.push_back({Op::constant, -1, -1, x});
    std::uniform_int_distribution<std::size_t> any_op(0, named.size() - 1);
    for (int i = 0; i < operations; ++i) {
        const int size = static_cast<int>(nodes.size());
        std::uniform_int_distribution<int> any(0, size - 1), late(std::max(0, size - 6), size - 1);
        const Op op = i % 3 == 0 ? named[any_op(random)] : i % 2 ? Op::mul : Op::add;
        nodes.push_back({op, late(random), info_of(op).operands == 2 ? any(random) : -1, 0});
    }
    return nodes;
}

std::vector<Forward> values_of(const std::vector<FormulaNode>& nodes, const double (&at)[7]) {
    std::vector<Forward> values;
    for (const FormulaNode& n : nodes) {
        if (n.op == Op::constant) values.emplace_back(n.value);
        else if (n.op == Op::input) values.push_back(n.a < 6 ? Forward::variable(at[n.a], n.a) : Forward(at[n.a]));
        else values.push_back(apply(n.op, values[n.a], n.b < 0 ? Forward(0.0) : values[n.b]));
    }
    return values;
}

/// Whether the numbers on the way are of ordinary size and not at a jump, so that rounding stays rounding.
bool tame(const std::vector<FormulaNode>& nodes, const std::vector<Forward>& values) {
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const Forward& v = values[i];
        if (nodes[i].op == Op::atan2 && std::abs(values[nodes[i].a].value) < 1e-3) return false;
        const bool kink = nodes[i].op == Op::min || nodes[i].op == Op::max;
        if (kink && std::abs(values[nodes[i].a].value - values[nodes[i].b].value) < 1e-3) return false;
        if (nodes[i].op == Op::abs && std::abs(v.value) < 1e-3) return false;
        if (!(std::abs(v.value) < 1e4)) return false;
        for (const double d : v.derivative)
            if (!(std::abs(d) < 1e4)) return false;
    }
    return true;
}

// Where two numbers are equal the derivative is that of the first, whichever way it is computed.
TEST(FormulaPrograms, TakeTheFirstOfEqualNumbers) {
    const auto programs = std::make_unique<formula::Programs>();
    const double at[7] = {0.5, 0.5, 0, 0.25, 0.25, 0, 1};
    for (const Op op : {Op::min, Op::max, Op::abs})
        for (const int first : {0, 1, 3, 4}) {
            std::vector<FormulaNode> nodes;
            for (int i = 0; i < 7; ++i) nodes.push_back({Op::input, i, -1, 0});
            if (op == Op::abs) nodes.push_back({op, first < 3 ? 2 : 5, -1, 0});
            else nodes.push_back({op, first, first < 3 ? 1 - first : 7 - first, 0});
            const auto values = values_of(nodes, at);
            const Formula f{nodes.data(), 8, 7, -1, -1, -1, -1, {-1, -1}, 0, at[6]};
            ASSERT_EQ(formula::compile(f, nullptr, *programs), nullptr);
            double gradient[6];
            formula::evaluate(programs->derivatives, at, gradient);
            for (int k = 0; k < 6; ++k)
                EXPECT_EQ(gradient[k], values[7].derivative[k]) << static_cast<int>(op) << ' ' << first << ' ' << k;
        }
}

TEST(FormulaPrograms, HaveTheValuesAndTheGradientOfTheFormula) {
    std::mt19937 random(2003);
    std::uniform_real_distribution<double> anywhere(-2, 2);
    const auto programs = std::make_unique<formula::Programs>();
    int compared = 0;
    for (int i = 0; i < 4000; ++i) {
        const auto nodes = random_nodes(random, 4 + i % 40);
        const int root = static_cast<int>(nodes.size()) - 1;
        double at[7];
        for (double& x : at) x = anywhere(random);
        const auto values = values_of(nodes, at);
        if (!tame(nodes, values)) continue;
        const Formula f{nodes.data(), static_cast<std::uint32_t>(nodes.size()), root, -1, -1, -1, -1, {-1, -1}, 0.25,
                        at[6]};
        ASSERT_EQ(formula::compile(f, nullptr, *programs), nullptr);
        double gradient[6], energy[1], force[3], velocity[3];
        formula::evaluate(programs->derivatives, at, gradient);
        formula::evaluate(programs->value, at, energy);
        formula::evaluate(programs->force, at, force);
        formula::evaluate(programs->velocity, at, velocity);
        PacketDouble in[7], out[6];
        for (int k = 0; k < 7; ++k) in[k] = PacketDouble(at[k]);
        formula::evaluate(programs->derivatives, in, out);
        // A hundred operations on numbers up to 1e4, and what those amplify.
        const double rounding = 1e-8;
        ASSERT_NEAR(energy[0], values[root].value - 0.25, rounding) << i;
        for (int k = 0; k < 6; ++k) {
            ASSERT_NEAR(gradient[k], values[root].derivative[k], rounding) << i << ' ' << k;
            ASSERT_NEAR(k < 3 ? force[k] : velocity[k - 3], gradient[k], rounding) << i << ' ' << k;
            ASSERT_NEAR(get_lane(out[k], lane_count<PacketDouble> - 1), gradient[k], rounding) << i << ' ' << k;
        }
        ++compared;
    }
    EXPECT_GT(compared, 1000);
}

TEST(FormulaPrograms, TooLargeOnesAreRefused) {
    std::mt19937 random(1);
    const auto nodes = random_nodes(random, 4000);
    std::vector<FormulaNode> sum = nodes;
    for (int i = 7; i < 4000 && sum.size() < formula_limit; ++i)
        sum.push_back({Op::add, static_cast<int>(sum.size()) - 1, i, 0});
    const Formula f{sum.data(), static_cast<std::uint32_t>(sum.size()), static_cast<int>(sum.size()) - 1, -1, -1, -1, -1, {-1, -1}, 0, 0};
    const auto programs = std::make_unique<formula::Programs>();
    EXPECT_NE(formula::compile(f, nullptr, *programs), nullptr);
}

}  // namespace
}  // namespace kagero::test
