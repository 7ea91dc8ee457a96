// Tests of the compiler module with random formulas: machine code must give the same bits as the interpreter, where NaN
// is equal to NaN. The environment variable KAGERO_RANDOM_FORMULAS states the number of random formulas, and
// KAGERO_RANDOM_POINTS the number of points of each.
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
    formula::evaluate(interpreted, in, expected);
    formula::evaluate(compiled, in, out);
    for (int o = 0; o < interpreted.outputs; ++o)
        ASSERT_EQ(differing_lanes(out[o], expected[o]), 0) << "output " << o << ", lanes " << lane_count<V>;
}

/// Compares the evaluation in two parts, for two values of the varying inputs.
template <class V>
void compare_prepared(const Code& interpreted, const Code& compiled, VaryingInputs varying, const State<V>& s,
                      const V* other) {
    formula::PreparedGradient<V> a(interpreted, s, varying), b(compiled, s, varying);
    for (const Vec3<V>& in : {Vec3<V>{other[0], other[1], other[2]}, Vec3<V>{other[3], other[4], other[5]}}) {
        const Vec3<V> expected = a(in), out = b(in);
        ASSERT_EQ(differing_lanes(out.x, expected.x) + differing_lanes(out.y, expected.y) +
                      differing_lanes(out.z, expected.z),
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
        compare_prepared(p.interpreted->force, p.compiled->force, kick_varies, s, other.y);
        compare_prepared(p.interpreted->velocity, p.compiled->velocity, drift_varies, s, other.y);
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
        formula::StageEvaluator<V> a(p.interpreted->derivatives, stages), b(p.compiled->derivatives, stages);
        for (int i = 0; i < stages; ++i)
            for (int k = 0; k < state_size; ++k) a.input(i, k) = b.input(i, k) = random_value<V>(random);
        a.run();
        b.run();
        for (int i = 0; i < stages; ++i) {
            V expected[phase_size], out[phase_size];
            a.read(i, expected);
            b.read(i, out);
            for (int k = 0; k < phase_size; ++k) ASSERT_EQ(differing_lanes(out[k], expected[k]), 0) << "stage " << i;
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
    std::mt19937 random(3);
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
        });
        ++compared;
    }
    EXPECT_GT(compared, formulas / 2);
}

}  // namespace
}  // namespace kagero::test
