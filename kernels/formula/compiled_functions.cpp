// Translation of a formula's code to the nodes that the compiler module receives, and the functions that compiled code
// calls.
#include "kernels/formula/compiled_functions.h"
#include "kernels/simd/packed.h"

#include <utility>

namespace kagero::formula {
namespace {

// ---- the functions of the operations ------------------------------------------------------------------------------

/// Computes op(a, b, c), exactly as the interpreter does.
template <Op op, class V>
void compute(const void* a, const void* b, const void* c, void* result, void*) {
    // Operands that the operation does not have are replaced by a, so that only valid memory is read.
    constexpr int operands = Operation<op>::operands;
    const V &x = *static_cast<const V*>(a), &y = *static_cast<const V*>(operands > 1 ? b : a),
            &z = *static_cast<const V*>(operands > 2 ? c : a);
    *static_cast<V*>(result) = kagero::detail::apply_total<op, false, V>(x, y, z);
}
/// As `compute`, for values with 4 registers: computes halves with 2 registers, so that fewer functions are compiled.
template <Op op, class S>
void compute_halves(const void* a, const void* b, const void* c, void* result, void*) {
    using Half = Lanes<S, 2>;
    constexpr int operands = Operation<op>::operands;
    for (int half = 0; half < 2; ++half) {
        const auto part = [&](const void* of) { return static_cast<const Half*>(of) + half; };
        compute<op, Half>(part(a), operands > 1 ? part(b) : nullptr, operands > 2 ? part(c) : nullptr,
                          static_cast<Half*>(result) + half, nullptr);
    }
}
/// Computes two operations of a. The compiler evaluates their common parts only once.
template <Op first, Op second, class V>
void compute_both(const void* a, const void*, const void*, void* result, void* second_result) {
    const V x = *static_cast<const V*>(a);
    *static_cast<V*>(result) = kagero::detail::apply_total<first, false, V>(x, x, x);
    *static_cast<V*>(second_result) = kagero::detail::apply_total<second, false, V>(x, x, x);
}
/// As `compute_both`, for values with 4 registers.
template <Op first, Op second, class S>
void compute_both_halves(const void* a, const void*, const void*, void* result, void* second_result) {
    using Half = Lanes<S, 2>;
    for (int half = 0; half < 2; ++half)
        compute_both<first, second, Half>(static_cast<const Half*>(a) + half, nullptr, nullptr,
                                          static_cast<Half*>(result) + half, static_cast<Half*>(second_result) + half);
}
/// True for values with 4 registers.
template <class V>
inline constexpr bool has_halves = ValueTraits<V>::registers == 4;
template <Op first, Op second, class V>
constexpr OperationFunction joint_function() {
    if constexpr (has_halves<V>) return &compute_both_halves<first, second, ScalarOf<V>>;
    else return &compute_both<first, second, V>;
}
template <class V>
constexpr JointOperation joint_operations[] = {{Op::sin, Op::cos, joint_function<Op::sin, Op::cos, V>()}};

template <Op op, class V>
OperationFunction operation_function() {
    if constexpr (is_leaf(op)) return nullptr;
    else if constexpr (Operation<op>::is_abbreviation) return nullptr;
    else if constexpr (has_halves<V>) return &compute_halves<op, ScalarOf<V>>;
    else return &compute<op, V>;
}
struct OperationFunctions {
    OperationFunction list[op_count];
};
template <class V, int... ops>
OperationFunctions operation_functions(std::integer_sequence<int, ops...>) {
    return {{operation_function<static_cast<Op>(ops), V>()...}};
}

#if defined(__AVX512F__)
constexpr InstructionSet this_isa = InstructionSet::avx512;
#elif defined(__AVX2__)
constexpr InstructionSet this_isa = InstructionSet::avx2;
#else
constexpr InstructionSet this_isa = InstructionSet::sse2;
#endif

template <class V>
ValueType value_type() {
    static const OperationFunctions functions = operation_functions<V>(std::make_integer_sequence<int, op_count>{});
    constexpr int registers = ValueTraits<V>::registers;
    return {this_isa, sizeof(ScalarOf<V>) == sizeof(float) ? Precision::float32 : Precision::float64,
            lane_count<V> / registers, registers, functions.list, joint_operations<V>, std::size(joint_operations<V>)};
}
/// Returns the type with an index of `compiled_type`.
const ValueType& value_type_at(int index) {
    static const ValueType types[compiled_type_count] = {
        value_type<Lanes<double, 2>>(), value_type<Lanes<float, 2>>(), value_type<double>(),
        value_type<float>(),            value_type<Lanes<double, 1>>(), value_type<Lanes<double, 4>>(),
        value_type<Lanes<float, 1>>(),  value_type<Lanes<float, 4>>()};
    return types[index];
}

// ---- nodes ---------------------------------------------------------------------------------------------------------

/// The nodes of a code: inputs, constants, and one node per instruction.
class DecodedProgram {
public:
    explicit DecodedProgram(const Code& code) : code_(code) {
        for (int i = 0; i < code_.inputs; ++i) node_in_slot_[i] = append({Op::input, i, -1, -1, 0});
        for (int i = 0; i < code.constants; ++i)
            node_in_slot_[code_.inputs + i] = append({Op::constant, -1, -1, -1, code.constant[i]});
        for (int r = 0; r < code.runs; ++r) {
            if (r == code.prepared_runs) first_varying_ = count_;
            for (int i = 0; i < code.run[r].count; ++i)
                append_instruction(code.run[r].opcode, code.instruction[code.run[r].first + i]);
        }
        if (code.prepared_runs == code.runs) first_varying_ = count_;
        for (int o = 0; o < code.outputs; ++o) output_[o] = node_in_slot_[code.output[o]];
        find_prepared_values();
    }
    bool has_prepared_values() const { return prepared_count_ > 0; }

    FunctionDescription whole(const ValueType& type) const { return describe(type, nodes_, code_.inputs, output_); }
    /// Returns the program that computes the values that do not depend on the varying inputs.
    FunctionDescription prepare(const ValueType& type) const {
        FunctionDescription f = describe(type, nodes_, code_.inputs, prepared_);
        f.output_count = static_cast<std::uint32_t>(prepared_count_);
        return f;
    }
    /// Returns the program that computes the outputs from the inputs and these values.
    FunctionDescription evaluate_prepared(const ValueType& type) {
        std::copy_n(nodes_, count_, rest_);
        for (int i = 0; i < prepared_count_; ++i) rest_[prepared_[i]] = {Op::input, code_.inputs + i, -1, -1, 0};
        return describe(type, rest_, code_.inputs + prepared_count_, output_);
    }

private:
    static constexpr int max_nodes = Code::max_slots + Tape::capacity;

    int append(const ProgramNode& node) {
        nodes_[count_] = node;
        return count_++;
    }
    void append_instruction(std::uint8_t opcode, const Instruction& instruction) {
        const auto operand = [&](std::uint16_t offset) { return node_in_slot_[offset / Instruction::offset_unit]; };
        const int a = operand(instruction.a), b = operand(instruction.b), c = operand(instruction.c);
        last_ = append(node_of(opcode, a, b, c));
        node_in_slot_[instruction.result / Instruction::offset_unit] = last_;
    }
    /// Returns the node of an instruction; `last_` is the accumulator.
    ProgramNode node_of(std::uint8_t opcode, int a, int b, int c) const {
        if (opcode < opcode_of(AccumulatorOp::add)) {
            const Op op = static_cast<Op>(opcode);
            return {op, a, info_of(op).operands > 1 ? b : -1, info_of(op).operands > 2 ? c : -1, 0};
        }
        switch (static_cast<AccumulatorOp>(opcode)) {
            case AccumulatorOp::add: return {Op::add, last_, b, -1, 0};
            case AccumulatorOp::mul: return {Op::mul, last_, b, -1, 0};
            case AccumulatorOp::rsqrt: return {Op::rsqrt, last_, -1, -1, 0};
            case AccumulatorOp::recip: return {Op::recip, last_, -1, -1, 0};
            case AccumulatorOp::fma: return {Op::fma, last_, b, c, 0};
            case AccumulatorOp::add_product: return {Op::fma, a, b, last_, 0};
            case AccumulatorOp::fnma: return {Op::fnma, last_, b, c, 0};
            default: return {Op::fnma, a, b, last_, 0};
        }
    }
    /// Lists the values of prepared instructions that later instructions or the outputs use.
    void find_prepared_values() {
        bool used[max_nodes] = {};
        for (int k = first_varying_; k < count_; ++k)
            for (const int operand : {nodes_[k].a, nodes_[k].b, nodes_[k].c})
                if (operand >= 0) used[operand] = true;
        for (int o = 0; o < code_.outputs; ++o) used[output_[o]] = true;
        for (int k = code_.inputs + code_.constants; k < first_varying_; ++k)
            if (used[k]) prepared_[prepared_count_++] = k;
    }
    FunctionDescription describe(const ValueType& type, const ProgramNode* nodes, int inputs,
                                 const std::int32_t* outputs) const {
        return {&type,
                nodes,
                static_cast<std::uint32_t>(count_),
                static_cast<std::uint32_t>(inputs),
                outputs,
                static_cast<std::uint32_t>(code_.outputs)};
    }

    const Code& code_;
    ProgramNode nodes_[max_nodes], rest_[max_nodes];
    std::int32_t output_[Code::max_outputs], prepared_[max_nodes];
    int node_in_slot_[Code::max_slots] = {};
    int count_ = 0;           ///< number of nodes
    int first_varying_ = 0;   ///< first node that depends on the varying inputs
    int prepared_count_ = 0;  ///< number of prepared values
    int last_ = 0;            ///< node of the last instruction
};

/// Returns the number of value types for which programs are compiled.
int type_count(const Programs& p) { return p.for_comparison ? compiled_type_count : interpreted_type_count; }

/// Passes a forward program to the sink. The state has the same values in all lanes, and the derivative by component k
/// of the range is in lane k.
void describe_forward(const ForwardProgram& forward, const ForwardRange& range, void* user, FunctionSink sink) {
    ProgramNode nodes[Tape::capacity];
    for (int i = 0; i < forward.size; ++i) {
        const Node& n = forward.nodes[i];
        if (n.op == Op::input && n.a >= state_size) nodes[i] = {Op::constant, n.a - state_size, -1, -1, 1};
        else nodes[i] = {n.op, n.a, n.b, n.c, n.value};
    }
    const int type = range.last - range.first > space_size ? compiled_type<Packed<double, phase_size>>
                                                           : compiled_type<Packed<double, space_size>>;
    const std::int32_t output = forward.output;
    const FunctionDescription function{&value_type_at(type), nodes, static_cast<std::uint32_t>(forward.size),
                                       state_size,           &output, 1, true};
    sink(user, &function);
}

/// Calls visit(code) for every code of the programs.
template <class SomePrograms, class Visit>
void visit_codes(SomePrograms& p, const Visit& visit) {
    for (auto* code :
         {&p.derivatives, &p.force, &p.velocity, &p.energy_residual, &p.time_rescaling_factor, &p.event_functions,
          &p.switching_function, &p.part_force[0], &p.part_force[1], &p.part_velocity[0], &p.part_velocity[1]})
        if (code->outputs > 0) visit(*code);  // a program that the formula does not need has no outputs
}

}  // namespace

void describe_functions(const double* programs, void* user, FunctionSink sink) {
    visit_codes(programs_in(programs), [&](const Code& code) {
        DecodedProgram program(code);
        for (int type = 0; type < type_count(programs_in(programs)); ++type) {
            const FunctionDescription whole = program.whole(value_type_at(type));
            sink(user, &whole);
            if (!program.has_prepared_values()) continue;
            const FunctionDescription prepare = program.prepare(value_type_at(type)),
                                      rest = program.evaluate_prepared(value_type_at(type));
            sink(user, &prepare);
            sink(user, &rest);
        }
    });
    for (int i = 0; i < forward_count; ++i)
        if (const ForwardProgram& forward = programs_in(programs).forward[i]; forward.size > 0)
            describe_forward(forward, forward_ranges[i], user, sink);
}

void set_parameters(double* programs, const double* values) {
    Programs& p = *reinterpret_cast<Programs*>(programs);
    std::copy_n(values, p.parameters, p.parameter);
}

void use_functions(double* programs, const CompiledFunction* functions) {
    Programs& all = *reinterpret_cast<Programs*>(programs);
    visit_codes(all, [&](Code& code) {
        const bool prepares = DecodedProgram(code).has_prepared_values();
        for (int type = 0; type < type_count(all); ++type) {
            CompiledProgram& program = code.compiled[type];
            program.evaluate = program.evaluate_prepared = *functions++;
            if (!prepares) continue;
            program.prepare = *functions++;
            program.evaluate_prepared = *functions++;
        }
    });
    for (ForwardProgram& forward : all.forward)
        if (forward.size > 0) forward.evaluate = *functions++;
    all.is_compiled = true;
}

}  // namespace kagero::formula
