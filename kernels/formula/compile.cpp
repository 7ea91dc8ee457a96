// Compilation of a formula: the parsed list of nodes is recorded on a tape, and programs that are extracted from the
// tape are written as code (code.h).
#include "kernels/formula/programs.h"
#include "kernels/autodiff/squares.h"
#include "kernels/autodiff/tangent.h"

#include <algorithm>

namespace kagero::formula {
namespace {

static_assert(Tape::capacity == 768 && Code::max_slots == 256);
constexpr const char* too_large =
    "the formula is too large: with its derivatives it needs more than 768 operations, or more than 256 values at the "
    "same time; write a simpler formula";

/// A tape on which the expressions of one formula are recorded. If the formula only rescales a compiled Hamiltonian,
/// that Hamiltonian is recorded as H.
struct FormulaTape {
    const Formula& formula;
    const RerecordedHamiltonian* compiled;  ///< the compiled Hamiltonian that the formula rescales, or nullptr
    Tape tape{};
    std::array<int, state_size> input{};

    explicit FormulaTape(const Formula& f, const RerecordedHamiltonian* c = nullptr) : formula(f), compiled(c) {
        for (int i = 0; i < state_size; ++i) input[i] = tape.input(i);
    }
    /// Records H − H0 and returns its node.
    int energy_residual() {
        if (compiled) return compiled->record_energy_residual(tape, formula.parameters);
        return tape.sub(expression(formula.energy), tape.constant(formula.level));
    }
    /// Records Ω and returns its node.
    int time_rescaling_factor() {
        if (formula.rescale >= 0) return expression(formula.rescale);
        return compiled->record_time_rescaling_factor(tape, formula.parameters);
    }
    /// Records the event functions that the formula defines.
    void record_events(const std::array<int, phase_size>& gradient,
                       std::array<int, event_function_count>& event_functions) {
        if (compiled) return compiled->record_events(tape, formula.parameters, gradient, event_functions);
        if (formula.domain >= 0) event_functions[index_domain] = expression(formula.domain, value_only);
        if (formula.capture >= 0) event_functions[index_captured] = expression(formula.capture, value_only);
        if (formula.length_scale >= 0)
            event_functions[index_max_step_length] = expression(formula.length_scale, value_only);
    }
    /// Records the switching function of H and returns its node: the product, over every operation with branches on
    /// which H depends, of the argument whose sign selects the branch, or of the difference of the arguments. Each
    /// factor is divided by its typical magnitude. Equal factors, such as those of the two gates of a `where`, occur
    /// only once, because their product would not change its sign. Returns −1 if there are none.
    int switching_function() {
        if (compiled) return -1;
        const std::array<bool, max_formula_nodes> needed = nodes_needed_by(formula.energy);
        std::array<bool, Tape::capacity> is_factor{};
        int product = -1;
        for (std::int32_t i = 0; i <= formula.energy && !tape.full; ++i) {
            const FormulaNode& n = formula.nodes[i];
            if (!needed[i] || !has_branches(n.op)) continue;
            const double magnitude = formula.branch_magnitudes ? formula.branch_magnitudes[i] : 1;
            const int argument = expression(n.a, value_only),
                      factor = branches_by_sign(n.op) ? argument : tape.sub(argument, expression(n.b, value_only)),
                      scaled = tape.mul(tape.constant(1 / magnitude), factor);
            if (is_factor[factor] || is_factor[tape.neg(factor)]) continue;
            is_factor[factor] = true;
            product = product < 0 ? scaled : tape.mul(product, scaled);
        }
        return product;
    }
    /// Use of an expression: its derivatives are needed, or only its value.
    enum Use { differentiated, value_only };
    /// Records the expression whose last formula node is `root`, and returns its node on the tape. Only formula nodes
    /// on which the expression depends are recorded.
    int expression(std::int32_t root, Use use = differentiated) {
        const std::array<bool, max_formula_nodes> needed = nodes_needed_by(root);
        std::array<int, max_formula_nodes> tape_node{};
        for (std::int32_t i = 0; i <= root && !tape.full; ++i) {
            const FormulaNode& n = formula.nodes[i];
            if (!needed[i]) continue;
            if (n.op == Op::constant) tape_node[i] = tape.constant(n.value);
            else if (n.op == Op::parameter) tape_node[i] = tape.parameter(n.a);
            else if (n.op == Op::input) tape_node[i] = input[n.a];
            else if (n.op == Op::sqrt && use == value_only) tape_node[i] = record_sqrt(tape_node[n.a]);
            else tape_node[i] = record(tape, n.op, tape_node[n.a], n.b < 0 ? -1 : tape_node[n.b]);
        }
        return tape_node[root];
    }

private:
    /// Returns for each formula node whether the node `root` depends on it.
    std::array<bool, max_formula_nodes> nodes_needed_by(std::int32_t root) const {
        std::array<bool, max_formula_nodes> needed{};
        needed[root] = true;
        for (std::int32_t i = root; i >= 0; --i) {
            const FormulaNode& n = formula.nodes[i];
            if (!needed[i] || is_leaf(n.op)) continue;
            needed[n.a] = true;
            if (n.b >= 0) needed[n.b] = true;
        }
        return needed;
    }
    /// Records √s for the node s and returns its node. The tape usually computes √s as s · (1/√s), which is NaN at s =
    /// 0. Here this is done only if the tape already contains 1/√s.
    int record_sqrt(int s) {
        const auto is_reciprocal = [s](const Node& n) { return n.op == Op::rsqrt && n.a == s; };
        const bool has_reciprocal = std::any_of(tape.nodes, tape.nodes + tape.size, is_reciprocal);
        return has_reciprocal ? tape.sqrt(s) : tape.unary(Op::sqrt, s);
    }
};

/// Writes the program of the given outputs as code. Returns false if it is too large.
template <std::size_t n>
bool write(const Tape& t, const std::array<int, n>& outputs, VaryingInputs varying, Code& code) {
    const auto program = detail::extract_untrimmed<static_cast<int>(n)>(t, outputs, varying);
    return CodeWriter(program, varying, code).write();
}

/// Returns the nodes of the program of the gradient, for evaluation by interpreter.h.
Nodes gradient_nodes(const Tape& t, const std::array<int, phase_size>& outputs) {
    const auto program = detail::extract_untrimmed<phase_size>(t, outputs, {});
    Nodes nodes{};
    nodes.size = program.size;
    std::copy_n(program.nodes, program.size, nodes.nodes);
    std::copy_n(program.outputs.begin(), phase_size, nodes.outputs);
    return nodes;
}

constexpr VaryingInputs all_inputs{};

/// Writes ∂K/∂q and ∂K/∂p as code, from the nodes g of the gradient. Sets `separable` to true if K = ½|p|² + V(q), else
/// to false. Returns false if the code is too large.
bool write_gradient_halves(const Tape& t, const std::array<int, phase_size>& g, Code& force, Code& velocity,
                           bool& separable) {
    std::array<int, space_size> force_nodes, velocity_nodes;
    for (int k = 0; k < space_size; ++k) {
        force_nodes[k] = g[k];
        velocity_nodes[k] = g[momentum(k)];
    }
    separable = is_separable(detail::extract_untrimmed<space_size>(t, force_nodes, kick_varies),
                             detail::extract_untrimmed<space_size>(t, velocity_nodes, drift_varies));
    return write(t, force_nodes, kick_varies, force) && write(t, velocity_nodes, drift_varies, velocity);
}

/// Returns true if the expression at node `root` has few nodes when it is expanded to a tree, in which nodes with
/// several uses are repeated. Some transformations traverse this tree, which may be far larger than the list of nodes.
bool small_as_tree(const Tape& t, int root) {
    std::array<double, Tape::capacity> size{};
    for (int i = 0; i <= root; ++i) {
        size[i] = 1;
        if (is_leaf(t.nodes[i].op)) continue;
        for (const int operand : {t.nodes[i].a, t.nodes[i].b})
            if (operand >= 0) size[i] += size[operand];
    }
    return size[root] < 5000;
}

/// Factors the perfect squares in a sum (autodiff/squares.h), unless the sum is too large, and returns the node of the
/// result.
int collect_squares_if_small(Tape& t, int sum) {
    return !t.full && small_as_tree(t, sum) ? collect_squares(t, sum) : sum;
}

/// The nodes of H − H0, Ω and K on the tape of a formula.
struct HamiltonianNodes {
    int residual, rescaling, hamiltonian;
};
HamiltonianNodes record_hamiltonian(FormulaTape& formula_tape, bool rescaled) {
    Tape& t = formula_tape.tape;
    const int residual = collect_squares_if_small(t, formula_tape.energy_residual()), one = t.constant(1);
    if (!rescaled) return {residual, one, residual};
    const int rescaling = formula_tape.time_rescaling_factor();
    return {residual, rescaling,
            small_as_tree(t, residual) ? multiply_through(t, rescaling, residual) : t.mul(rescaling, residual)};
}

/// Records the event functions and returns their nodes. Writes the program of the switching function, if there is one,
/// and sets `fits` to false if it is too large.
std::array<int, event_function_count> write_switching_function(FormulaTape& formula_tape, const HamiltonianNodes& nodes,
                                                               const std::array<int, phase_size>& g, Programs& p,
                                                               bool& fits) {
    Tape& t = formula_tape.tape;
    std::array<int, event_function_count> functions = record_event_functions(
        t, formula_tape.input, nodes.hamiltonian, nodes.rescaling, formula_tape.formula.level, g);
    formula_tape.record_events(g, functions);
    const int kinks = formula_tape.switching_function();
    p.has_kinks = kinks >= 0;
    if (p.has_kinks) functions[index_switching] = kinks;
    fits = !t.full;
    if (fits && (p.has_kinks || p.discontinuous))
        fits = write(t, std::array{functions[index_switching]}, all_inputs, p.switching_function);
    return functions;
}

/// Writes all programs of a formula except those of the parts H_A and H_B. Returns false if they are too large.
bool write_main_programs(const Formula& f, const RerecordedHamiltonian* compiled, Programs& p) {
    FormulaTape formula_tape(f, compiled);
    Tape& t = formula_tape.tape;
    const HamiltonianNodes nodes = record_hamiltonian(formula_tape, p.rescaled);
    if (t.full) return false;
    const std::array<int, phase_size> g = record_derivatives(t, nodes.hamiltonian, formula_tape.input);
    bool fits = true;
    const auto event_functions = write_switching_function(formula_tape, nodes, g, p, fits);
    if (!fits || !write(t, std::array{nodes.residual}, all_inputs, p.energy_residual)) return false;
    p.derivative_nodes = gradient_nodes(t, g);
    std::array<int, formula_function_count> with_rescaling{};
    std::copy(event_functions.begin(), event_functions.end(), with_rescaling.begin());
    with_rescaling[index_time_rescaling] = nodes.rescaling;
    if (!write(t, g, all_inputs, p.derivatives) || !write(t, with_rescaling, all_inputs, p.event_functions))
        return false;
    return write(t, std::array{nodes.rescaling}, all_inputs, p.time_rescaling_factor) &&
           write_gradient_halves(t, g, p.force, p.velocity, p.separable);
}

/// Writes the program that differentiates K in forward mode by some components of the state. If the program is too
/// large, its size remains 0.
void write_forward_program(const Formula& f, const RerecordedHamiltonian* compiled, bool rescaled,
                           const ForwardRange& range, ForwardProgram& to) {
    FormulaTape formula_tape(f, compiled);
    Tape& t = formula_tape.tape;
    const int count = range.last - range.first, hamiltonian = record_hamiltonian(formula_tape, rescaled).hamiltonian;
    if (t.full) return;
    std::array<int, phase_size> seeds{};
    for (int k = 0; k < count; ++k) seeds[k] = t.input(state_size + k);
    const int tangent = record_tangent(t, hamiltonian, formula_tape.input.data() + range.first, seeds.data(), count);
    if (t.full) return;
    const auto program = detail::extract_untrimmed<1>(t, std::array{tangent}, {});
    if (!program.complete) return;
    to.size = program.size;
    to.output = program.outputs[0];
    std::copy_n(program.nodes, program.size, to.nodes);
}

/// Writes the programs of the part H_A (index 0) or H_B (index 1). Returns false if they are too large.
bool write_part(const Formula& f, int index, Programs& p) {
    FormulaTape formula_tape(f);
    Tape& t = formula_tape.tape;
    const int part = formula_tape.expression(f.parts[index]);
    if (t.full) return false;
    const std::array<int, phase_size> g = record_derivatives(t, part, formula_tape.input);
    bool separable;  // of this part; not used
    return !t.full && write_gradient_halves(t, g, p.part_force[index], p.part_velocity[index], separable);
}

}  // namespace

const char* compile(const Formula& f, const RerecordedHamiltonian* compiled, Programs& p) {
    p = {};
    p.level = f.level;
    p.pt = f.pt;
    p.rescaled = f.rescale >= 0 || f.declared_rescaling;
    p.parted = f.parts[0] >= 0;
    p.parameters = static_cast<int>(f.parameter_count);
    p.bounds_steps = compiled ? compiled->bounds_steps : f.length_scale >= 0;
    p.is_compiled_hamiltonian = compiled != nullptr;
    p.discontinuous = compiled && compiled->discontinuous;
    p.for_comparison = f.for_comparison;
    if (f.node_count > max_formula_nodes) return too_large;
    bool fits = write_main_programs(f, compiled, p);
    for (int i = 0; i < 2 && p.parted; ++i) fits = fits && write_part(f, i, p);
    for (int i = 0; i < forward_count && fits && f.for_comparison; ++i)
        write_forward_program(f, compiled, p.rescaled, forward_ranges[i], p.forward[i]);
    return fits ? nullptr : too_large;
}

}  // namespace kagero::formula
