// Tests of the compiler module: machine code must give the same bits as the interpreter, where NaN is equal to NaN. The
// environment variable KAGERO_RANDOM_FORMULAS states the number of random formulas, and KAGERO_RANDOM_POINTS the number
// of points of each.
#include "compiler/formula_compiler.h"
#include "kernels/formula/formula_system.h"
#include "kernels/simd/lane_memory.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <random>
#include <sstream>
#include <tuple>

namespace kagero::test {
namespace {

using formula::Code;
using formula::CompiledProgram;
using formula::Programs;

/// Returns a new compiler of the module; nullptr if the module cannot be loaded.
std::unique_ptr<FunctionCompiler> new_compiler() {
    void* library = dlopen(KAGERO_COMPILER_FILE, RTLD_NOW);
    void* entry = library ? dlsym(library, "kagero_compiler") : nullptr;
    return entry ? reinterpret_cast<CompilerFunction>(entry)()->create() : nullptr;
}

class CompiledFormula : public ::testing::Test {
protected:
    void SetUp() override {
        if (std::string(KAGERO_COMPILER_FILE).empty()) GTEST_SKIP() << "the compiler module is not built";
        compiler = new_compiler();
        ASSERT_NE(compiler, nullptr) << dlerror();
    }
    std::unique_ptr<FunctionCompiler> compiler;
};

int setting(const char* variable, int default_value) {
    const char* value = std::getenv(variable);
    return value ? std::atoi(value) : default_value;
}

/// Calls visit.operator()<V>() for every value type that is compiled.
template <class Visit>
void visit_types(const Visit& visit) {
    visit.template operator()<Lanes<double, 2>>();
    visit.template operator()<Lanes<float, 2>>();
    visit.template operator()<double>();
    visit.template operator()<float>();
}

/// Returns a random number; one in ten is a special value.
double random_number(std::mt19937& random) {
    constexpr double special[] = {0.0, -0.0, 1, -1, INFINITY, -INFINITY, NAN, 1e-310, 1e300, -1e-30, 1e30};
    std::uniform_int_distribution<int> any(0, 99);
    if (const int k = any(random); k < int(std::size(special))) return special[k];
    return std::normal_distribution<double>(0, 2)(random);
}
template <class V>
V random_value(std::mt19937& random) {
    double numbers[lane_count<V>];
    for (double& x : numbers) x = random_number(random);
    return lanes_of<V>(numbers);
}

/// Returns the number of lanes in which the bits of two values differ, unless both are NaN.
template <class V>
int differing_lanes(const V& a, const V& b) {
    int count = 0;
    for (int lane = 0; lane < lane_count<V>; ++lane) {
        const ScalarOf<V> x = get_lane(a, lane), y = get_lane(b, lane);
        if (!(std::isnan(x) && std::isnan(y)) && std::memcmp(&x, &y, sizeof x) != 0) ++count;
    }
    return count;
}

// ---- programs of random operations --------------------------------------------------------------------------------

/// A random program. It may contain every operation of the table that programs can contain.
struct RandomProgram {
    std::vector<ProgramNode> nodes;
    std::vector<std::int32_t> outputs;
    static constexpr int inputs = 9;

    static std::vector<Op> all_operations() {
        std::vector<Op> all;
        for (int i = int(Op::input) + 1; i < op_count; ++i)
            if (!operation_infos[i].is_abbreviation) all.push_back(static_cast<Op>(i));
        return all;
    }
    /// `reach` is the greatest distance between a node and its operands. With a long reach, many values are needed at
    /// the same time.
    RandomProgram(std::mt19937& random, int operations, int reach, bool only_arithmetic) {
        static const std::vector<Op> all = all_operations();
        for (int i = 0; i < inputs; ++i) nodes.push_back({Op::input, i, -1, -1, 0});
        for (const double x : {0.5, -1.0, 0.0, 3.7}) nodes.push_back({Op::constant, -1, -1, -1, x});
        for (int i = 0; i < operations; ++i) {
            std::uniform_int_distribution<std::size_t> any_op(0, only_arithmetic ? 6 : all.size() - 1);
            const int size = int(nodes.size());
            std::uniform_int_distribution<int> any_node(std::max(0, size - reach), size - 1);
            const Op op = all[any_op(random)];
            const int operands = info_of(op).operands;
            nodes.push_back(
                {op, any_node(random), operands > 1 ? any_node(random) : -1, operands > 2 ? any_node(random) : -1, 0});
        }
        for (int o = 0; o < 6; ++o)
            outputs.push_back(std::uniform_int_distribution<int>(0, int(nodes.size()) - 1)(random));
    }
    FunctionDescription description(const ValueType& type) const {
        return {&type,  nodes.data(),   std::uint32_t(nodes.size()),
                inputs, outputs.data(), std::uint32_t(outputs.size())};
    }
};

/// Returns the value type of V, from the description of a formula.
template <class V>
const ValueType& type_of() {
    static const ValueType* found = nullptr;
    const FormulaNode nodes[] = {{Op::input, 0, -1, 0}};
    Formula f{};
    f.nodes = nodes;
    f.node_count = 1;
    f.domain = f.capture = f.length_scale = f.rescale = f.parts[0] = f.parts[1] = -1;
    const auto programs = std::make_unique<Programs>();
    EXPECT_EQ(formula::compile(f, nullptr, *programs), nullptr);
    formula::describe_functions(*programs, nullptr, [](void*, const FunctionDescription* d) {
        const bool is_double = d->type->precision == Precision::float64;
        if (is_double == (sizeof(ScalarOf<V>) == 8) && (d->type->lanes == 1) == (lane_count<V> == 1)) found = d->type;
    });
    return *found;
}

/// Evaluates a program node by node.
template <class V>
void evaluate_nodes(const RandomProgram& program, const V* in, V* out) {
    std::vector<V> value(program.nodes.size());
    for (std::size_t i = 0; i < value.size(); ++i) {
        const ProgramNode& n = program.nodes[i];
        const auto operand = [&](int k) { return k < 0 ? V(ScalarOf<V>(0)) : value[std::size_t(k)]; };
        if (n.op == Op::input) value[i] = in[n.a];
        else if (n.op == Op::constant) value[i] = V(ScalarOf<V>(n.value));
        else value[i] = kagero::detail::apply_at_run_time<V>(n.op, operand(n.a), operand(n.b), operand(n.c));
    }
    for (std::size_t o = 0; o < program.outputs.size(); ++o) out[o] = value[std::size_t(program.outputs[o])];
}

/// Compares a function with the evaluation node by node, at several points that one call evaluates.
template <class V>
void expect_equal_bits(const RandomProgram& program, CompiledFunction function, std::mt19937& random) {
    constexpr int points = 3, outputs = 6;
    V in[points * RandomProgram::inputs], out[points * outputs], expected[outputs];
    for (V& x : in) x = random_value<V>(random);
    function(in, out, points);
    for (int p = 0; p < points; ++p) {
        evaluate_nodes(program, in + p * RandomProgram::inputs, expected);
        for (int o = 0; o < outputs; ++o)
            ASSERT_EQ(differing_lanes(out[p * outputs + o], expected[o]), 0)
                << "output " << o << " of point " << p << ", lanes " << lane_count<V>;
    }
}

TEST_F(CompiledFormula, RandomProgramsHaveTheBitsOfTheirNodes) {
    std::mt19937 random(1);
    std::vector<RandomProgram> programs;
    for (int i = 0; i < 400; ++i) programs.emplace_back(random, 5 + 3 * (i % 100), i % 2 ? 12 : 200, i % 3 == 0);
    visit_types([&]<class V>() {
        for (const RandomProgram& program : programs) compiler->add(program.description(type_of<V>()));
    });
    const std::vector<CompiledFunction> functions = compiler->finish();
    const CompiledFunction* function = functions.data();
    visit_types([&]<class V>() {
        for (const RandomProgram& program : programs) expect_equal_bits<V>(program, *function++, random);
    });
}

/// Returns a program whose outputs are operations of the operands a, b and c.
RandomProgram program_of(std::mt19937& random, const std::vector<Op>& operations, int a, int b, int c) {
    RandomProgram program(random, 0, 1, true);
    for (const Op op : operations) {
        const int operands = info_of(op).operands;
        program.nodes.push_back({op, a, operands > 1 ? b : -1, operands > 2 ? c : -1, 0});
    }
    const auto first = int(program.nodes.size() - operations.size());
    for (std::size_t o = 0; o < program.outputs.size(); ++o) program.outputs[o] = first + int(o % operations.size());
    return program;
}

// Every operation of the table, and every pair of joint operations, with operands that are inputs and constants.
TEST_F(CompiledFormula, EveryOperationHasTheBitsOfTheKernel) {
    std::mt19937 random(2);
    std::vector<std::vector<Op>> all;
    for (const Op op : RandomProgram::all_operations()) all.push_back({op});
    for (std::uint32_t j = 0; j < type_of<double>().joint_operation_count; ++j) {
        const JointOperation& joint = type_of<double>().joint_operations[j];
        all.push_back({joint.first, joint.second});
        all.push_back({joint.second, joint.first});
    }
    std::vector<RandomProgram> programs;
    for (const std::vector<Op>& operations : all)
        for (int variant = 0; variant < 27; ++variant) {
            const int choices[] = {0, 1, RandomProgram::inputs};
            programs.push_back(
                program_of(random, operations, choices[variant % 3], choices[variant / 3 % 3], choices[variant / 9]));
        }
    visit_types([&]<class V>() {
        for (const RandomProgram& program : programs) compiler->add(program.description(type_of<V>()));
    });
    const std::vector<CompiledFunction> functions = compiler->finish();
    const CompiledFunction* function = functions.data();
    visit_types([&]<class V>() {
        for (const RandomProgram& program : programs) {
            SCOPED_TRACE("operation " + std::to_string(int(program.nodes.back().op)));
            for (int i = 0; i < 3; ++i) expect_equal_bits<V>(program, *function, random);
            ++function;
        }
    });
}

// ---- random formulas -----------------------------------------------------------------------------------------------

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
    formula::describe_functions(programs, &compiler, [](void* user, const FunctionDescription* function) {
        static_cast<FunctionCompiler*>(user)->add(*function);
    });
    formula::use_functions(programs, compiler.finish().data());
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

// ---- memory --------------------------------------------------------------------------------------------------------

TEST_F(CompiledFormula, MemoryIsNeverWritableAndExecutable) {
    std::mt19937 random(4);
    const RandomProgram program(random, 100, 20, false);
    compiler->add(program.description(type_of<double>()));
    const auto address = reinterpret_cast<std::uintptr_t>(compiler->finish().front());
    const auto permissions_at = [](std::uintptr_t wanted) {
        std::ifstream maps("/proc/self/maps");
        std::string line, found;
        while (std::getline(maps, line)) {
            unsigned long first = 0, last = 0;
            char permissions[8] = {};
            if (std::sscanf(line.c_str(), "%lx-%lx %7s", &first, &last, permissions) != 3) continue;
            EXPECT_FALSE(permissions[1] == 'w' && permissions[2] == 'x') << line;
            if (first <= wanted && wanted < last) found = permissions;
        }
        return found;
    };
    EXPECT_EQ(permissions_at(address).substr(0, 3), "r-x");
    compiler.reset();
    EXPECT_EQ(permissions_at(address), "") << "the memory was not freed";
}

}  // namespace
}  // namespace kagero::test
