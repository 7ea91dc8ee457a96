// Tests that the tape preserves values when it simplifies expressions, and that it records correct derivatives. Random
// expressions are recorded on a tape, and its nodes are evaluated one by one. The results are compared with the same
// expressions of dual numbers in quadruple precision.
#include "tests/kernels/steps.h"

#include <cstdio>
#include <memory>
#include <optional>

namespace kagero::test {
namespace {

constexpr int inputs = 4, parameters = 2, variables = inputs + parameters;
/// A value with its derivatives with respect to all variables.
using DualQuad = Dual<Quad, variables>;

/// Values of the leaves of a tape.
struct LeafValues {
    std::vector<Quad> input, parameter;
};
LeafValues random_leaves(Random& random) {
    LeafValues l{std::vector<Quad>(inputs), std::vector<Quad>(parameters)};
    for (Quad& x : l.input) x = random(0.5, 2);
    for (Quad& x : l.parameter) x = random(0.5, 2);
    return l;
}

/// Returns the result of the operation of a node in quadruple precision, independently of operation_table.h.
Quad result_of(const Node& n, Quad a, Quad b, Quad c) {
    switch (n.op) {
        case Op::add: return a + b;
        case Op::sub: return a - b;
        case Op::mul: return a * b;
        case Op::neg: return -a;
        case Op::recip: return 1 / a;
        case Op::sqrt: return sqrt(a);
        case Op::rsqrt: return 1 / sqrt(a);
        case Op::exp: return exp(a);
        case Op::log: return log(a);
        case Op::sin: return sin(a);
        case Op::cos: return cos(a);
        case Op::tan: return tan(a);
        case Op::tanh: return tanh(a);
        case Op::atan2: return atan2(a, b);
        case Op::min: return min(a, b);
        case Op::max: return max(a, b);
        case Op::at_least: return a >= b ? 1 : 0;
        case Op::fma: return a * b + c;
        case Op::fms: return a * b - c;
        case Op::fnma: return c - a * b;
        default: return 0;
    }
}
/// Returns the values of the first `count` nodes of a tape or program.
template <class Nodes>
std::vector<Quad> evaluate(const Nodes& nodes, int count, const LeafValues& leaves) {
    std::vector<Quad> value(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
        const Node& n = nodes[i];
        const auto operand = [&](int k) { return k >= 0 ? value[static_cast<std::size_t>(k)] : Quad(0); };
        if (n.op == Op::constant) value[i] = n.value;
        else if (n.op == Op::parameter) value[i] = leaves.parameter[n.a];
        else if (n.op == Op::input) value[i] = leaves.input[n.a];
        else value[i] = result_of(n, operand(n.a), operand(n.b), operand(n.c));
    }
    return value;
}

/// A part of a random expression: as recorded on the tape, and as a dual number.
struct Term {
    Recorded recorded;
    DualQuad dual;
};

/// Returns the result of a random operation on random terms. Operands that are equal or constant are frequent, because
/// the tape simplifies such operations.
Term random_operation(Random& random, const std::vector<Term>& terms) {
    const auto any_term = [&] { return terms[static_cast<std::size_t>(random.below(static_cast<int>(terms.size())))]; };
    const Term a = any_term(), b = random.below(5) == 0 ? a : any_term();
    const bool positive = a.dual.value > Quad(0.1), moderate = abs(a.dual.value) < 3;
    switch (random.below(16)) {
        case 0: case 1: return {a.recorded + b.recorded, a.dual + b.dual};
        case 2: case 3: return {a.recorded - b.recorded, a.dual - b.dual};
        case 4: case 5: case 6: return {a.recorded * b.recorded, a.dual * b.dual};
        case 7: if (abs(b.dual.value) > Quad(0.1)) return {a.recorded / b.recorded, a.dual / b.dual}; break;
        case 8: return {-a.recorded, -a.dual};
        case 9: case 10: if (positive) return {sqrt(a.recorded), sqrt(a.dual)}; break;
        case 11: if (moderate) return {exp(a.recorded), exp(a.dual)}; break;
        case 12: if (positive) return {log(a.recorded), log(a.dual)}; break;
        case 13: if (moderate) return {tanh(sin(a.recorded)), tanh(sin(a.dual))}; break;
        case 14: if (moderate) return {cos(a.recorded) * tan(b.recorded), cos(a.dual) * tan(b.dual)}; break;
        default:
            if (abs(a.dual.value - b.dual.value) > Quad(0.1))
                return {max(a.recorded, b.recorded), max(a.dual, b.dual)};
    }
    return {min(a.recorded, a.recorded + 1.0), min(a.dual, a.dual + 1.0)};
}

/// Records a random expression of the leaves on t and returns it. Sets `nodes` to the nodes of inputs and parameters.
Term random_expression(Random& random, Tape& t, const LeafValues& leaves, std::array<int, variables>& nodes) {
    std::vector<Term> terms;
    for (int i = 0; i < variables; ++i) {
        nodes[i] = i < inputs ? t.input(i) : t.parameter(i - inputs);
        const Quad value = i < inputs ? leaves.input[i] : leaves.parameter[i - inputs];
        terms.push_back({Recorded(&t, nodes[i]), DualQuad::variable(value, i)});
    }
    for (const double c : {0.0, 1.0, -1.0, 2.0}) terms.push_back({Recorded(&t, t.constant(c)), DualQuad(c)});
    for (int i = 0; i < 25; ++i) {
        const Term next = random_operation(random, terms);
        Quad size = abs(next.dual.value);
        for (const Quad d : next.dual.derivative) size = max(size, abs(d));
        if (size < 1e4) terms.push_back(next);
    }
    Term sum = terms.back();  // sum of the later half of the terms, so that the result depends on most of them
    for (std::size_t i = terms.size() / 2; i + 1 < terms.size(); ++i)
        sum = {sum.recorded + terms[i].recorded, sum.dual + terms[i].dual};
    return sum;
}

/// Expects equality up to 4096 rounding errors of double. The tape folds constants in double, and the expression
/// amplifies the rounding errors of folding. All other operations are in quadruple precision.
void expect_equal(Quad found, Quad expected, const char* description) {
    EXPECT_LE(static_cast<double>(abs(found - expected)),
              4096 * machine_epsilon<double> * (1 + static_cast<double>(abs(expected))))
        << description;
}

constexpr int expressions = 300;

TEST(Tape, SimplificationPreservesValues) {
    Random random(21);
    for (int round = 0; round < expressions; ++round) {
        auto t = std::make_unique<Tape>();
        const LeafValues leaves = random_leaves(random);
        std::array<int, variables> nodes;
        const Term e = random_expression(random, *t, leaves, nodes);
        ASSERT_LT(t->size, Tape::capacity);
        expect_equal(evaluate(t->nodes, t->size, leaves)[e.recorded.node], e.dual.value, "value");
    }
}

TEST(Tape, ReverseSweepMatchesDualNumbers) {
    Random random(22);
    for (int round = 0; round < expressions; ++round) {
        auto t = std::make_unique<Tape>();
        const LeafValues leaves = random_leaves(random);
        std::array<int, variables> nodes, gradient{};
        const Term e = random_expression(random, *t, leaves, nodes);
        record_gradient<variables>(*t, e.recorded.node, nodes, gradient);
        ASSERT_LT(t->size, Tape::capacity);
        const auto value = evaluate(t->nodes, t->size, leaves);
        for (int k = 0; k < variables; ++k) expect_equal(value[gradient[k]], e.dual.derivative[k], "derivative");
    }
}

// Extraction removes unused nodes, fuses products into sums, and renumbers the nodes.
TEST(Tape, ExtractedProgramsMatchDualNumbers) {
    Random random(23);
    for (int round = 0; round < expressions; ++round) {
        auto t = std::make_unique<Tape>();
        const LeafValues leaves = random_leaves(random);
        std::array<int, variables> nodes, gradient{};
        const Term e = random_expression(random, *t, leaves, nodes);
        record_gradient<variables>(*t, e.recorded.node, nodes, gradient);
        const auto p = kagero::detail::extract_untrimmed<variables>(*t, gradient);
        EXPECT_LE(p.size, t->size);
        const auto value = evaluate(p.nodes, p.size, leaves);
        for (int k = 0; k < variables; ++k) expect_equal(value[p.outputs[k]], e.dual.derivative[k], "derivative");
    }
}

TEST(Tape, MultiplyThroughMatchesMultiplication) {
    Random random(24);
    for (int round = 0; round < expressions; ++round) {
        auto t = std::make_unique<Tape>();
        const LeafValues leaves = random_leaves(random);
        std::array<int, variables> nodes;
        const Term e = random_expression(random, *t, leaves, nodes);
        // The factor is √(x² + y²), its cube, or an input, like the time rescalings Ω of spaces. Only some terms of
        // `sum` are divided by the factor.
        const Recorded x(t.get(), nodes[0]), y(t.get(), nodes[1]), r = sqrt(x * x + y * y);
        const Recorded factor = round % 3 == 0 ? r : round % 3 == 1 ? r * r * r : x;
        const Recorded sum = e.recorded / factor - 0.5 * (x / r) * e.recorded * e.recorded + e.recorded;
        const int product = multiply_through(*t, factor.node_on(*t), sum.node_on(*t));
        const auto value = evaluate(t->nodes, t->size, leaves);
        expect_equal(value[product] / (1 + abs(e.dual.value)),
                     value[factor.node] * value[sum.node] / (1 + abs(e.dual.value)), "product");
    }
}

// The sum contains c·(Σ ± s)² in expanded form, and other terms. Each s is an input, and may be multiplied by a
// parameter and by 1/r.
TEST(Tape, CollectSquaresFindsPerfectSquares) {
    Random random(25);
    for (int round = 0; round < expressions; ++round) {
        auto t = std::make_unique<Tape>();
        const LeafValues leaves = random_leaves(random);
        std::vector<Recorded> x;
        for (int i = 0; i < inputs; ++i) x.push_back({t.get(), t->input(i)});
        const Recorded k(t.get(), t->parameter(0)), m(t.get(), t->parameter(1)),
            r = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
        std::vector<Recorded> summands;
        for (int i = 0; i < 2 + random.below(inputs - 1); ++i) {
            Recorded summand = random.below(2) == 0 ? x[i] : -x[i];
            if (random.below(2) == 0) summand = summand * k;
            if (random.below(2) == 0) summand = summand / r;
            summands.push_back(summand);
        }
        const Recorded factor = random.below(2) == 0 ? -0.5 * m : m / (r * r * r);
        Recorded sum = x[0] * x[3] - k * m * x[1] + cos(x[2]);
        for (std::size_t i = 0; i < summands.size(); ++i)
            for (std::size_t j = 0; j <= i; ++j)
                sum = sum + factor * summands[i] * summands[j] * Recorded(i == j ? 1 : 2);
        const int before = kagero::detail::operations_to(*t, sum.node), shorter = collect_squares(*t, sum.node);
        EXPECT_LT(kagero::detail::operations_to(*t, shorter), before);
        const auto value = evaluate(t->nodes, t->size, leaves);
        expect_equal(value[shorter], value[sum.node], "sum");
    }
}

TEST(Tape, CollectSquaresKeepsSumsWithoutPerfectSquare) {
    Tape t;
    const Recorded x(&t, t.input(0)), y(&t, t.input(1)), k(&t, t.parameter(0));
    for (const Recorded& sum :
         {x * x + y * y + 1.9 * x * y, x * x - y * y + 2.0 * x * y, x * x + k * y * y + 2.0 * k * x * y, x * x * y + y})
        EXPECT_EQ(collect_squares(t, sum.node), sum.node);
    const Recorded square = x * x + y * y - 2.0 * x * y;
    EXPECT_EQ(kagero::detail::operations_to(t, collect_squares(t, square.node)), 2);
}

TEST(Tape, SquaresThatShareATermHaveCorrectSigns) {
    // (x + y)² − 2xz + (z + w)²: the cross term of x and z is negative, the cross term of z and w is positive.
    Random random(26);
    auto t = std::make_unique<Tape>();
    const Recorded x(t.get(), t->input(0)), y(t.get(), t->input(1)), z(t.get(), t->input(2)), w(t.get(), t->input(3));
    const Recorded sum = x * x + 2.0 * x * y + y * y - 2.0 * x * z + z * z + 2.0 * z * w + w * w;
    const int shorter = collect_squares(*t, sum.node);
    const auto value = evaluate(t->nodes, t->size, random_leaves(random));
    expect_equal(value[shorter], value[sum.node], "sum");
}

// Exponents up to 63 can be represented (126 in units of ½).
TEST(Tape, CollectSquaresKeepsPowersThatAreTooHigh) {
    Tape t;
    const Recorded x(&t, t.input(0)), y(&t, t.input(1));
    Recorded high = x;
    for (int i = 0; i < 7; ++i) high = high * high;  // x to the 128th
    const Recorded sum = high * x * x + 2.0 * x * y + y * y;
    EXPECT_EQ(collect_squares(t, sum.node), sum.node);
}

TEST(Tape, AlgebraicIdentitiesAreSimplified) {
    Tape t;
    const Recorded x(&t, t.input(0)), y(&t, t.input(1)), k(&t, t.parameter(0)), s = x * x + y * y, r = sqrt(s);
    const auto node = [](const Recorded& a) { return a.node; };
    EXPECT_EQ(node(r * r), node(s));
    EXPECT_EQ(node(x * y), node(y * x));
    EXPECT_EQ(node(x + 0.0), node(x));
    EXPECT_EQ(node(1.0 * x), node(x));
    EXPECT_EQ(node(-(-x)), node(x));
    EXPECT_EQ(node(x - x), node(0.0 * y));
    EXPECT_EQ(node((2.0 * x) * k), node((2.0 * k) * x));
    EXPECT_EQ(multiply_through(t, r.node, (1.0 / r).node), t.constant(1));
}

// The output is itself a leaf. Its derivative is 1 with respect to itself, and 0 with respect to leaves that precede or
// follow it on the tape.
TEST(Tape, GradientOfALeafIsAUnitVector) {
    Tape t;
    const std::array<int, 3> leaves{t.input(0), t.input(1), t.parameter(0)};
    for (int output = 0; output < 3; ++output) {
        std::array<int, 3> gradient{};
        record_gradient<3>(t, leaves[output], leaves, gradient);
        for (int k = 0; k < 3; ++k) EXPECT_EQ(gradient[k], t.constant(k == output)) << output << ' ' << k;
    }
}

template <class H>
class TapeOfHamiltonian : public ::testing::Test {};
TYPED_TEST_SUITE(TapeOfHamiltonian, AllHamiltonians, HamiltonianName);

/// Returns ∂H/∂k for each parameter k by the tape. Each derivative is recorded on a separate tape, because one tape may
/// be too small for all derivatives. The derivative by `seed` of `shimmer`, on which the phases of all waves depend,
/// has no value: even a separate tape is too small for it.
template <class H>
std::vector<std::optional<Quad>> derivatives_by_parameters(const LeafValues& leaves) {
    std::vector<std::optional<Quad>> derivatives;
    for (std::size_t i = 0; i < leaves.parameter.size(); ++i) {
        auto t = std::make_unique<Tape>();
        const Leaves<H> x(*t);
        std::array<int, 1> gradient{};
        record_gradient<1>(*t, record_energy_residual<H>(*t, x), {x.k[i].node}, gradient);
        EXPECT_EQ(t->full, std::string(H::parameters[i].name) == "seed") << H::parameters[i].name;
        if (t->full) derivatives.emplace_back();
        else derivatives.emplace_back(evaluate(t->nodes, t->size, leaves)[gradient[0]]);
    }
    return derivatives;
}

// The reference is computed by propagation of dual numbers through H, without a tape.
TYPED_TEST(TapeOfHamiltonian, ParameterDerivativesMatchDualNumbers) {
    using H = TypeParam;
    constexpr int count = static_cast<int>(H::parameters.size());
    using DualNumber = Dual<Quad, count + 1>;
    Random random(27);
    for (int round = 0; round < 5; ++round) {
        LeafValues leaves{std::vector<Quad>(state_size), std::vector<Quad>(count)};
        DualNumber k[count + 1], y[state_size];
        for (int i = 0; i < state_size; ++i) y[i].value = leaves.input[i] = random(0.3, 2);
        for (int i = 0; i < count; ++i) {
            leaves.parameter[i] = H::parameters[i].default_value * random(0.9, 1);
            k[i] = DualNumber::variable(leaves.parameter[i], i);
        }
        const DualNumber energy = H::energy(make_parameters<H>(k), {y[0], y[1], y[2]}, {y[3], y[4], y[5]}, y[6]);
        const auto derivatives = derivatives_by_parameters<H>(leaves);
        for (int i = 0; i < count; ++i)
            if (derivatives[i]) expect_equal(*derivatives[i], energy.derivative[i], H::parameters[i].name);
    }
}

/// Returns the number of operations that a program performs for every ray.
int op_count_of(const auto& program) {
    int n = 0;
    for (const Node& node : program.nodes) n += !node.uniform && node.op != Op::input;
    return n;
}

// The program of the force alone, or of the velocity alone, has at most as many operations as the program of all
// derivatives. The counts are printed, so that an increase is noticed.
TYPED_TEST(TapeOfHamiltonian, ForceAndVelocityProgramsAreNotLonger) {
    using H = TypeParam;
    const auto record = [](const std::string& prefix, int all, int force, int velocity) {
        ::testing::Test::RecordProperty(prefix + "derivatives", all);
        ::testing::Test::RecordProperty(prefix + "force", force);
        ::testing::Test::RecordProperty(prefix + "velocity", velocity);
        std::printf("%s%s: %d operations for all derivatives, %d for the force, %d for the velocity\n", prefix.c_str(),
                    H::name, all, force, velocity);
        EXPECT_LE(force, all);
        EXPECT_LE(velocity, all);
    };
    record("", op_count_of(derivatives_program<H, false>), op_count_of(force_program<H, false>),
           op_count_of(velocity_program<H, false>));
    if constexpr (Rescalable<H>)
        record("rescaled_", op_count_of(derivatives_program<H, true>), op_count_of(force_program<H, true>),
               op_count_of(velocity_program<H, true>));
}

}  // namespace

}  // namespace kagero::test
