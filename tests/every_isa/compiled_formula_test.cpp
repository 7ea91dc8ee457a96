// Tests of the compiler module with random formulas: machine code must give the same bits as the interpreter, where NaN
// is equal to NaN. The environment variable KAGERO_RANDOM_FORMULAS states the number of random formulas, and
// KAGERO_RANDOM_POINTS the number of points of each. KAGERO_RANDOM_SEED selects other formulas.
#include "tests/every_isa/compiler_fixture.h"

namespace kagero::test {
namespace {

using formula::Code;
using formula::Programs;

class CompiledFormula : public CompilerTest {};

/// A random formula: nodes of H, of the bounds, and of parts.
struct RandomFormula {
    std::vector<FormulaNode> nodes;
    Formula formula{};

    RandomFormula(std::mt19937& random, int operations) {
        std::vector<Op> named;
        for (int i = 0; i < op_count; ++i)
            if (*operation_infos[i].name) named.push_back(static_cast<Op>(i));
        for (int i = 0; i < state_size; ++i) nodes.push_back({Op::input, i, -1, 0});
        for (const double x : {0.5, -1.0, 2.0, 0.0, 3.7}) nodes.push_back({Op::constant, -1, -1, x});
        const int expressions = 5;
        for (int i = 0; i < operations + expressions; ++i) {
            const int size = int(nodes.size());
            std::uniform_int_distribution<int> any(0, size - 1), recent(std::max(0, size - 6), size - 1);
            const Op op = i % 3 == 0 ? named[std::size_t(any(random)) % named.size()] : i % 2 ? Op::mul : Op::add;
            nodes.push_back({op, recent(random), info_of(op).operands == 2 ? any(random) : -1, 0});
        }
        const int last = int(nodes.size()) - 1;
        const bool rescales = random() % 2, has_parts = random() % 2;
        formula.nodes = nodes.data();
        formula.node_count = std::uint32_t(nodes.size());
        formula.energy = last;
        formula.domain = last - 1;
        formula.capture = last - 2;
        formula.length_scale = last - 3;
        formula.rescale = rescales ? last - 4 : -1;
        formula.parts[0] = has_parts ? last - 1 : -1;
        formula.parts[1] = has_parts ? last - 2 : -1;
        formula.pt = 1;
        formula.for_comparison = true;
    }
};

/// The programs of a formula before and after their compilation.
struct TwoPrograms {
    std::unique_ptr<Programs> interpreted, compiled;
};

template <class V>
void compare_code(const Code& interpreted, const Code& compiled, const V* in) {
    if (interpreted.outputs == 0) return;
    ASSERT_NE(compiled.compiled_for<V>(), nullptr);
    V expected[Code::max_outputs], out[Code::max_outputs];
    interpret(interpreted, in, expected);
    formula::evaluate(compiled, in, out);
    for (int o = 0; o < interpreted.outputs; ++o)
        ASSERT_EQ(differing_lanes(out[o], expected[o]), 0) << "output " << o << ", lanes " << lane_count<V>;
}

/// Compares the evaluation in two parts with the interpreted evaluation, for two values of the varying inputs.
template <class V>
void compare_prepared(const Code& code, const Code& interpreted, VaryingInputs varying, const State<V>& s,
                      const V* other) {
    formula::PreparedGradient<V> prepared(code, s, varying);
    for (const V* in : {other, other + space_size}) {
        State<V> changed = s;
        for (int k = 0; k < space_size; ++k) changed.y[varying.first + k] = in[k];
        V expected[Code::max_outputs];
        interpret(interpreted, changed.y, expected);
        const Vec3<V> out = prepared({in[0], in[1], in[2]});
        ASSERT_EQ(differing_lanes(out.x, expected[0]) + differing_lanes(out.y, expected[1]) +
                      differing_lanes(out.z, expected[2]),
                  0)
            << "lanes " << lane_count<V>;
    }
}

template <class V>
void compare_programs(const TwoPrograms& p, std::mt19937& random, int points) {
    for (int i = 0; i < points; i += lane_count<V>) {
        State<V> s, other;
        for (V& x : s.y) x = random_value<V>(random);
        for (V& x : other.y) x = random_value<V>(random);
        for (const auto member :
             {&Programs::derivatives, &Programs::force, &Programs::velocity, &Programs::energy_residual,
              &Programs::time_rescaling_factor, &Programs::event_functions, &Programs::switching_function})
            compare_code<V>((*p.interpreted).*member, (*p.compiled).*member, s.y);
        compare_prepared(p.compiled->force, p.interpreted->force, kick_varies, s, other.y);
        compare_prepared(p.compiled->velocity, p.interpreted->velocity, drift_varies, s, other.y);
        if constexpr (formula::is_interpreted<V>)
            compare_prepared(p.interpreted->force, p.interpreted->force, kick_varies, s, other.y);
        for (int part = 0; part < 2 && p.interpreted->parted; ++part) {
            compare_code<V>(p.interpreted->part_force[part], p.compiled->part_force[part], s.y);
            compare_code<V>(p.interpreted->part_velocity[part], p.compiled->part_velocity[part], s.y);
        }
        if (::testing::Test::HasFatalFailure()) return;
    }
}

/// Compares the derivatives at several stages.
template <class V>
void compare_stages(const TwoPrograms& p, std::mt19937& random) {
    for (const int stages : {2, 3, 4, 6}) {
        formula::StageEvaluator<V> evaluator(p.compiled->derivatives, stages);
        V in[6][state_size];
        for (int i = 0; i < stages; ++i)
            for (int k = 0; k < state_size; ++k) evaluator.input(i, k) = in[i][k] = random_value<V>(random);
        evaluator.run();
        for (int i = 0; i < stages; ++i) {
            V expected[Code::max_outputs], out[phase_size];
            interpret(p.interpreted->derivatives, in[i], expected);
            evaluator.read(i, out);
            for (int k = 0; k < phase_size; ++k) ASSERT_EQ(differing_lanes(out[k], expected[k]), 0) << "stage " << i;
        }
    }
}

/// Compares the interpreter of several stages with that of one point.
template <class V>
void compare_interpreted_stages(const Code& code, std::mt19937& random) {
    if constexpr (formula::is_interpreted<V>)
        for (const int stages : {3, 4}) {
            formula::StageEvaluator<V> evaluator(code, stages);
            V in[4][state_size];
            for (int i = 0; i < stages; ++i)
                for (int k = 0; k < state_size; ++k) evaluator.input(i, k) = in[i][k] = random_value<V>(random);
            evaluator.run();
            for (int i = 0; i < stages; ++i) {
                V expected[Code::max_outputs], out[phase_size];
                interpret(code, in[i], expected);
                evaluator.read(i, out);
                for (int k = 0; k < phase_size; ++k) ASSERT_EQ(differing_lanes(out[k], expected[k]), 0);
            }
        }
}

/// Compiles the programs. The compiler must outlive their use.
void compile_with(FunctionCompiler& compiler, Programs& programs) {
    formula::describe_functions(reinterpret_cast<const double*>(&programs), &compiler,
                                [](void* user, const FunctionDescription* function) {
                                    static_cast<FunctionCompiler*>(user)->add(*function);
                                });
    formula::use_functions(reinterpret_cast<double*>(&programs), compiler.finish().data());
}

TEST_F(CompiledFormula, RandomFormulasHaveTheBitsOfTheInterpreter) {
    const int formulas = setting("KAGERO_RANDOM_FORMULAS", 150), points = setting("KAGERO_RANDOM_POINTS", 64);
    std::mt19937 random(unsigned(setting("KAGERO_RANDOM_SEED", 3)));
    int compared = 0;
    for (int i = 0; i < formulas && !HasFatalFailure(); ++i) {
        SCOPED_TRACE("formula " + std::to_string(i));
        const RandomFormula f(random, 3 + i % 40);
        TwoPrograms p{std::make_unique<Programs>(), std::make_unique<Programs>()};
        if (formula::compile(f.formula, nullptr, *p.interpreted)) continue;  // too large
        *p.compiled = *p.interpreted;
        const std::unique_ptr<FunctionCompiler> code = new_compiler();
        compile_with(*code, *p.compiled);
        visit_types([&]<class V>() {
            compare_programs<V>(p, random, points);
            compare_stages<V>(p, random);
            compare_interpreted_stages<V>(p.interpreted->derivatives, random);
        });
        ++compared;
    }
    EXPECT_GT(compared, formulas / 2);
}

/// Returns the derivatives of K by differentiation of the interpreted H − H0 with dual numbers.
std::array<double, phase_size> derivatives_by_dual_numbers(const Programs& p, const State<double>& s) {
    std::array<double, phase_size> all;
    for (const int first : {int(component_x), int(component_px)}) {
        Dual<double, space_size> in[state_size], out[1];
        formula::make_dual_inputs<space_size>(s, first, in);
        formula::evaluate_interpreted(p.energy_residual, in, out);
        for (int k = 0; k < space_size; ++k) all[std::size_t(first + k)] = out[0].derivative[std::size_t(k)];
    }
    return all;
}

/// Expects that a and b agree to a rounding error, relative to the greatest derivative.
void expect_close(const double* a, const double* b, int n) {
    double greatest = 0;
    for (int k = 0; k < n; ++k) greatest = std::max(greatest, std::abs(b[k]));
    for (int k = 0; k < n; ++k) EXPECT_NEAR(a[k], b[k], 1e-12 * (1 + greatest)) << "component " << k;
}

// The forward programs of per-ray kernels. The formulas have all kinds of operations, and moderate derivatives.
TEST_F(CompiledFormula, ForwardProgramsComputeTheGradient) {
    using enum Op;
    // Nodes 0 to 6 are the inputs x y z px py pz pt, and nodes 7 and 8 the constants 0.5 and 2.
    struct Operation {
        Op op;
        int a, b;
    };
    const std::vector<std::vector<Operation>> formulas{
        {{mul, 3, 3}, {mul, 4, 4}, {add, 9, 10}, {mul, 5, 5}, {add, 11, 12}, {mul, 7, 13}, {sin, 0, -1}, {exp, 1, -1},
         {mul, 15, 16}, {add, 14, 17}},
        {{mul, 0, 0}, {add, 9, 8}, {sqrt, 10, -1}, {div, 3, 11}, {mul, 12, 12}, {cos, 2, -1}, {mul, 14, 4},
         {sub, 13, 15}, {log, 10, -1}, {mul, 17, 5}, {add, 16, 18}},
        {{max, 0, 1}, {min, 3, 4}, {mul, 9, 10}, {abs, 2, -1}, {atan2, 0, 8}, {tanh, 5, -1}, {mul, 13, 14},
         {add, 11, 15}, {if_positive, 0, 16}, {mul, 12, 17}}};
    std::mt19937 random(7);
    std::uniform_real_distribution<double> number(0.1, 1.5);
    for (const std::vector<Operation>& operations : formulas) {
        std::vector<FormulaNode> nodes;
        for (int i = 0; i < state_size; ++i) nodes.push_back({input, i, -1, 0});
        for (const double x : {0.5, 2.0}) nodes.push_back({constant, -1, -1, x});
        for (const Operation& o : operations) nodes.push_back({o.op, o.a, o.b, 0});
        Formula f{};
        f.nodes = nodes.data();
        f.node_count = std::uint32_t(nodes.size());
        f.energy = int(nodes.size()) - 1;
        f.domain = f.capture = f.length_scale = f.rescale = f.parts[0] = f.parts[1] = -1;
        f.for_comparison = true;
        const auto p = std::make_unique<Programs>();
        ASSERT_EQ(formula::compile(f, nullptr, *p), nullptr);
        const std::unique_ptr<FunctionCompiler> code = new_compiler();
        compile_with(*code, *p);
        for (int i = 0; i < 50; ++i) {
            State<double> s;
            for (double& x : s.y) x = number(random) * (random() % 2 ? 1 : -1);
            const std::array<double, phase_size> expected = derivatives_by_dual_numbers(*p, s);
            for (int program = 0; program < formula::forward_count; ++program) {
                SCOPED_TRACE(program);
                const formula::ForwardRange range = formula::forward_ranges[program];
                ASSERT_GT(p->forward[program].size, 0);
                alignas(64) double out[16];
                p->forward[program].evaluate(s.y, out, 1);
                expect_close(out, expected.data() + range.first, range.last - range.first);
            }
        }
    }
}

}  // namespace
}  // namespace kagero::test
