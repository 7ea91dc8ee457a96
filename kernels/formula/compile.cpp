// From the list of nodes that a scene's formulas are parsed to, over the tape that all Hamiltonians use, to code.
#include "kernels/formula/programs.h"
#include "kernels/autodiff/squares.h"

#include <algorithm>

namespace kagero::formula {
namespace {

static_assert(Tape::capacity == 768 && Code::greatest_slots == 256);
constexpr const char* too_large =
    "it is too large: with its derivatives it takes more than 768 operations, or keeps more than 256 numbers at a time";

/// A tape with the inputs, onto which expressions of one formula are replayed.
struct Replay {
    const Formula& formula;
    const RerecordedHamiltonian* written;  ///< the compiled Hamiltonian that the formula rescales, if it does
    Tape tape{};
    std::array<int, state_size> input{};

    explicit Replay(const Formula& f, const RerecordedHamiltonian* w = nullptr) : formula(f), written(w) {
        for (int i = 0; i < state_size; ++i) input[i] = tape.input(i);
    }
    /// H − H0.
    int excess() {
        if (written) return written->energy(tape, formula.parameters);
        return tape.sub(expression(formula.energy), tape.constant(formula.level));
    }
    /// What is stated of the ends of steps.
    void ends(const std::array<int, phase_size>& gradient, std::array<int, event_function_count>& event_functions) {
        if (written) return written->ends(tape, formula.parameters, gradient, event_functions);
        if (formula.domain >= 0) event_functions[index_domain] = expression(formula.domain, value_alone);
        if (formula.capture >= 0) event_functions[index_captured] = expression(formula.capture, value_alone);
        if (formula.length_scale >= 0)
            event_functions[index_max_step_length] = expression(formula.length_scale, value_alone);
    }
    enum Use { differentiated, value_alone };
    /// The tape's node of an expression. Only what it needs is recorded.
    int expression(std::int32_t root, Use use = differentiated) {
        std::array<bool, formula_limit> needed{};
        needed[root] = true;
        for (std::int32_t i = root; i >= 0; --i) {
            const FormulaNode& n = formula.nodes[i];
            if (!needed[i] || detail::is_leaf(n.op)) continue;
            needed[n.a] = true;
            if (n.b >= 0) needed[n.b] = true;
        }
        std::array<int, formula_limit> place{};
        for (std::int32_t i = 0; i <= root && !tape.full; ++i) {
            const FormulaNode& n = formula.nodes[i];
            if (!needed[i]) continue;
            if (n.op == Op::constant) place[i] = tape.constant(n.value);
            else if (n.op == Op::input) place[i] = input[n.a];
            else if (n.op == Op::sqrt && use == value_alone) place[i] = value_of_root(place[n.a]);
            else place[i] = record(tape, n.op, place[n.a], n.b < 0 ? -1 : place[n.b]);
        }
        return place[root];
    }

private:
    /// √s; as s·(1/√s), which is no number at s = 0, only where H has computed that already.
    int value_of_root(int s) {
        const auto is_inverse = [s](const Node& n) { return n.op == Op::rsqrt && n.a == s; };
        const bool at_hand = std::any_of(tape.nodes, tape.nodes + tape.size, is_inverse);
        return at_hand ? tape.sqrt(s) : tape.unary(Op::sqrt, s);
    }
};

template <std::size_t n>
bool write(const Tape& t, const std::array<int, n>& outputs, Varying varying, Code& code) {
    const auto program = detail::extract_all<static_cast<int>(n)>(t, outputs, varying);
    return CodeWriter(program, varying, code).write();
}

Nodes listed(const Tape& t, const std::array<int, phase_size>& outputs) {
    const auto program = detail::extract_all<phase_size>(t, outputs, {});
    Nodes list{};
    list.size = program.size;
    std::copy_n(program.nodes, program.size, list.nodes);
    std::copy_n(program.outputs.begin(), phase_size, list.outputs);
    return list;
}

constexpr Varying everything{};

/// Force and velocity of a function of q and p, and whether it is separable.
bool write_sides(const Tape& t, const std::array<int, phase_size>& g, Code& force, Code& velocity, bool& separable) {
    std::array<int, space_size> q, p;
    for (int k = 0; k < space_size; ++k) q[k] = g[k], p[k] = g[momentum(k)];
    separable = is_separable(detail::extract_all<space_size>(t, q, kick_varies),
                             detail::extract_all<space_size>(t, p, drift_varies));
    return write(t, q, kick_varies, force) && write(t, p, drift_varies, velocity);
}

/// Some look at an expression as a tree, which may be far larger than the list of its nodes.
bool small_as_tree(const Tape& t, int root) {
    std::array<double, Tape::capacity> size{};
    for (int i = 0; i <= root; ++i) {
        size[i] = 1;
        if (detail::is_leaf(t.nodes[i].op)) continue;
        for (const int operand : {t.nodes[i].a, t.nodes[i].b})
            if (operand >= 0) size[i] += size[operand];
    }
    return size[root] < 5000;
}

int squares_together(Tape& t, int sum) {
    return !t.full && small_as_tree(t, sum) ? take_squares_together(t, sum) : sum;
}

bool write_motion(const Formula& f, const RerecordedHamiltonian* written, Programs& p) {
    Replay r(f, written);
    Tape& t = r.tape;
    const int excess = squares_together(t, r.excess());
    int k = excess, rescaling = t.constant(1);
    if (p.rescaled) {
        rescaling = r.expression(f.rescale);
        k = small_as_tree(t, excess) ? multiply_through(t, rescaling, excess) : t.mul(rescaling, excess);
    }
    if (t.full) return false;
    const std::array<int, phase_size> g = record_derivatives(t, k, r.input);
    std::array<int, event_function_count> event_functions =
        record_event_functions(t, r.input, k, rescaling, f.level, g);
    r.ends(g, event_functions);
    if (t.full || !write(t, std::array{excess}, everything, p.value)) return false;
    p.derivative_nodes = listed(t, g);
    std::array<int, formula_function_count> with_rescaling{};
    std::copy(event_functions.begin(), event_functions.end(), with_rescaling.begin());
    with_rescaling[index_time_rescaling] = rescaling;
    if (!write(t, g, everything, p.derivatives) || !write(t, with_rescaling, everything, p.event_functions))
        return false;
    return write(t, std::array{rescaling}, everything, p.time_rescaling_factor) &&
           write_sides(t, g, p.force, p.velocity, p.separable);
}

bool write_part(const Formula& f, int which, Programs& p) {
    Replay r(f);
    const int part = r.expression(f.parts[which]);
    if (r.tape.full) return false;
    const std::array<int, phase_size> g = record_derivatives(r.tape, part, r.input);
    bool ignored;
    return !r.tape.full && write_sides(r.tape, g, p.part_force[which], p.part_velocity[which], ignored);
}

}  // namespace

const char* compile(const Formula& f, const RerecordedHamiltonian* written, Programs& p) {
    p = {};
    p.level = f.level, p.pt = f.pt;
    p.rescaled = f.rescale >= 0, p.parted = f.parts[0] >= 0;
    p.bounds_steps = written ? written->bounds_steps : f.length_scale >= 0;
    if (f.node_count > formula_limit) return too_large;
    bool fits = write_motion(f, written, p);
    for (int i = 0; i < 2 && p.parted; ++i) fits = fits && write_part(f, i, p);
    return fits ? nullptr : too_large;
}

}  // namespace kagero::formula
