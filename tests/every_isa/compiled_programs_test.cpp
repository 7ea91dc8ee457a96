// Tests of the compiler module with programs of random operations: machine code must give the same bits as the
// functions of the kernel, where NaN is equal to NaN. Also tests the memory of the code.
#include "tests/every_isa/compiler_fixture.h"

#include <cstdio>
#include <fstream>

namespace kagero::test {
namespace {

class CompiledPrograms : public CompilerTest {};

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
    f.for_comparison = true;
    const auto programs = std::make_unique<formula::Programs>();
    EXPECT_EQ(formula::compile(f, nullptr, *programs), nullptr);
    formula::describe_functions(reinterpret_cast<const double*>(programs.get()), nullptr,
                                [](void*, const FunctionDescription* d) {
                                    const bool is_double = d->type->precision == Precision::float64;
                                    if (is_double == (sizeof(ScalarOf<V>) == 8) &&
                                        d->type->registers == std::uint32_t(ValueTraits<V>::registers) &&
                                        (d->type->lanes == 1) == (lane_count<V> == 1))
                                        found = d->type;
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

TEST_F(CompiledPrograms, RandomProgramsHaveTheBitsOfTheirNodes) {
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
TEST_F(CompiledPrograms, EveryOperationHasTheBitsOfTheKernel) {
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

TEST_F(CompiledPrograms, MemoryIsNeverWritableAndExecutable) {
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
