/// Programs as data: what formulas of a scene become, since no compiler is there to unroll them.
///
/// Instructions work on numbered slots: the inputs, the constants, then what is computed. They are ordered into runs of
/// the same operation on operands that do not wait for each other, so that an operation is looked up once per run and
/// fills the pipelines. Where there is no such run, an operation on the last result follows: it finds it in registers,
/// and does not wait for memory.
#pragma once

#include "kernels/equations/system.h"

#include <cstdint>

namespace kagero::formula {

/// Operands are places: slots times `unit`, so that a processor's addresses scale them to packets without further
/// arithmetic.
struct Instruction {
    static constexpr std::size_t unit = 16;
    std::uint16_t result, a, b, c;
};
static_assert(256 * Instruction::unit <= 1 << 16);

/// What a run does: an `Op`, or one of these, where L is the result of the instruction before.
enum class OnLast : std::uint8_t {
    add = op_count,   // L + b
    mul,              // L·b
    rsqrt, recip,     // of L
    fma,          // L·b + c
    add_product,      // a·b + L
    fnma,      // c − L·b
    minus_product,    // L − a·b
};
constexpr std::uint8_t kind_of(Op op) { return static_cast<std::uint8_t>(op); }
constexpr std::uint8_t kind_of(OnLast op) { return static_cast<std::uint8_t>(op); }

/// Instructions [first, first + count) of one kind. Of a run on the last result only the final one reaches its slot,
/// and of any run that one only where something else than the next instruction wants it.
struct Run {
    std::uint8_t kind;
    bool keep;
    std::uint16_t first, count;
};

/// Behind what a event_functions returns of any system, Ω.
enum { index_time_rescaling = event_function_count, formula_function_count };

struct Code {
    static constexpr int inputs = state_size, greatest_slots = 256, greatest_outputs = formula_function_count;
    std::int32_t slots, constants, runs, outputs;
    std::int32_t prepared;  ///< the first so many runs know nothing of the varying inputs
    Run run[Tape::capacity];
    Instruction instruction[Tape::capacity];
    double constant[greatest_slots];  ///< in slots from `inputs` on
    std::uint16_t output[greatest_outputs];
};

/// Orders a program and gives its results slots. False when it needs more slots than there are.
template <int Size, int Outputs>
class CodeWriter {
public:
    CodeWriter(const Program<Size, Outputs>& program, Varying varying, Code& code) : p_(program), code_(code) {
        for (int k = 0; k < p_.size; ++k) {
            const Node& n = p_.nodes[k];
            if (n.op == Op::input) varies_[k] = n.a >= varying.first && n.a < varying.last;
            else if (!detail::is_leaf(n.op))
                for (const int operand : {n.a, n.b, n.c})
                    if (operand >= 0) varies_[k] = varies_[k] || varies_[operand], ++uses_[operand];
        }
        for (const int o : p_.outputs) ++uses_[o];
    }

    bool write() {
        code_.runs = code_.constants = code_.prepared = 0;
        if (!p_.whole) return false;
        order(false);
        code_.prepared = code_.runs;
        first_varying_ = length_;
        order(true);
        find_last_uses();
        return place_leaves() && place_results();
    }

private:
    bool done(int k) const { return k < 0 || detail::is_leaf(p_.nodes[k].op) || done_[k]; }
    bool ready(int k, bool varying) const {
        const Node& n = p_.nodes[k];
        return !detail::is_leaf(n.op) && !done_[k] && varies_[k] == varying && done(n.a) && done(n.b) && done(n.c);
    }
    /// Runs of whichever operation is ready most often; where that is hardly any, what continues from the last result.
    void order(bool varying) {
        last_ = -1;
        for (;;) {
            int counts[op_count] = {}, best = 0;
            for (int k = 0; k < p_.size; ++k)
                if (ready(k, varying)) ++counts[static_cast<int>(p_.nodes[k].op)];
            for (int i = 1; i < op_count; ++i)
                if (counts[i] > counts[best]) best = i;
            if (counts[best] == 0) return;
            if (counts[best] < 3 && continue_from_last(varying)) continue;
            const int first = length_;
            for (int k = 0; k < p_.size; ++k)
                if (ready(k, varying) && static_cast<int>(p_.nodes[k].op) == best) order_[length_++] = k;
            for (int i = first; i < length_; ++i) done_[order_[i]] = true;
            last_ = order_[length_ - 1];
            code_.run[code_.runs++] = {static_cast<std::uint8_t>(best), true, static_cast<std::uint16_t>(first),
                                       static_cast<std::uint16_t>(length_ - first)};
        }
    }
    bool continue_from_last(bool varying) {
        for (int k = 0; last_ >= 0 && k < p_.size; ++k) {
            if (!ready(k, varying)) continue;
            const std::uint8_t kind = kind_on_last(p_.nodes[k]);
            if (kind == 0) continue;
            swap_[length_] = p_.nodes[k].b == last_;
            continue_run(kind, uses_[last_] == 1);
            order_[length_++] = last_ = k;
            done_[k] = true;
            return true;
        }
        return false;
    }
    /// One more instruction on the last result, which has `no_other_use`.
    void continue_run(std::uint8_t kind, bool no_other_use) {
        Run& before = code_.run[code_.runs - 1];
        if (no_other_use && before.kind == kind) {
            ++before.count;
            return;
        }
        if (no_other_use && (before.count == 1 || before.kind >= kind_of(OnLast::add))) before.keep = false;
        code_.run[code_.runs++] = {kind, true, static_cast<std::uint16_t>(length_), 1};
    }
    /// How a node uses the last result, once; 0 where it does not, or not in a way that has a kind.
    std::uint8_t kind_on_last(const Node& n) const {
        const bool a = n.a == last_, b = n.b == last_, c = n.c == last_;
        if (a + b + c != 1) return 0;
        switch (n.op) {
            case Op::add: return kind_of(OnLast::add);
            case Op::mul: return kind_of(OnLast::mul);
            case Op::rsqrt: return kind_of(OnLast::rsqrt);
            case Op::recip: return kind_of(OnLast::recip);
            case Op::fma: return kind_of(c ? OnLast::add_product : OnLast::fma);
            case Op::fnma: return kind_of(c ? OnLast::minus_product : OnLast::fnma);
            default: return 0;
        }
    }
    /// What the prepared part leaves to the rest, and the outputs, are used to the end.
    void find_last_uses() {
        for (int i = 0; i < length_; ++i) {
            const Node& n = p_.nodes[order_[i]];
            for (const int operand : {n.a, n.b, n.c})
                if (operand >= 0) last_use_[operand] = i >= first_varying_ && !varies_[operand] ? length_ : i;
        }
        for (const int o : p_.outputs) last_use_[o] = length_;
    }
    bool place_leaves() {
        for (int k = 0; k < p_.size; ++k) {
            const Node& n = p_.nodes[k];
            if (n.op == Op::input) slot_[k] = n.a;
            if (n.op != Op::constant) continue;
            if (Code::inputs + code_.constants == Code::greatest_slots) return false;
            slot_[k] = Code::inputs + code_.constants;
            code_.constant[code_.constants++] = n.value;
        }
        code_.slots = Code::inputs + code_.constants;
        return true;
    }
    bool place_results() {
        int free[Code::greatest_slots], free_count = 0;
        for (int i = 0; i < length_; ++i) {
            const int k = order_[i];
            const Node& n = p_.nodes[k];
            Instruction& to = code_.instruction[i];
            to = {0, place_of(swap_[i] ? n.b : n.a), place_of(swap_[i] ? n.a : n.b), place_of(n.c)};
            const int operands[3] = {n.a, n.b != n.a ? n.b : -1, n.c != n.a && n.c != n.b ? n.c : -1};
            for (const int operand : operands)
                if (operand >= 0 && !detail::is_leaf(p_.nodes[operand].op) && last_use_[operand] == i)
                    free[free_count++] = slot_[operand];
            if (free_count == 0 && code_.slots == Code::greatest_slots) return false;
            slot_[k] = free_count ? free[--free_count] : code_.slots++;
            to.result = place_of(k);
        }
        static_assert(Outputs <= Code::greatest_outputs);
        code_.outputs = Outputs;
        for (int o = 0; o < Outputs; ++o) code_.output[o] = slot_of(p_.outputs[o]);
        return true;
    }
    std::uint16_t slot_of(int k) const { return k < 0 ? std::uint16_t(0) : static_cast<std::uint16_t>(slot_[k]); }
    std::uint16_t place_of(int k) const { return static_cast<std::uint16_t>(slot_of(k) * Instruction::unit); }

    const Program<Size, Outputs>& p_;
    Code& code_;
    bool varies_[Size] = {}, done_[Size] = {};
    bool swap_[Size] = {};  ///< of each instruction: the last result, in b, belongs into a
    int order_[Size] = {}, uses_[Size] = {}, last_use_[Size] = {}, slot_[Size] = {};
    int length_ = 0, first_varying_ = 0, last_ = -1;
};

}  // namespace kagero::formula
