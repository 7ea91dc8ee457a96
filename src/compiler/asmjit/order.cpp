#include "compiler/asmjit/order.h"

#include <algorithm>
#include <array>

namespace kagero::compiler {
namespace {

/// Time of an operation in clock cycles, for recent processors: until its result is available, and until the next
/// operation can begin.
struct OperationTime {
    double latency, issue;
};
OperationTime time_of(Op op) {
    switch (op) {
        case Op::recip: return {27, 4};
        case Op::rsqrt: return {31, 5};
        case Op::sqrt: return {30, 6};
        case Op::min:
        case Op::max:
        case Op::at_least: return {10, 2};
        case Op::if_positive:
        case Op::unless_positive: return {14, 3};
        default: return info_of(op).is_library ? OperationTime{60, 30} : OperationTime{4, 0.5};
    }
}

/// List scheduling (Graham 1966) with a limit on the number of values in registers.
class ListScheduler {
public:
    ListScheduler(const UnrolledProgram& program, int register_count)
        : p_(program), limit_(register_count), needed_(p_.nodes.size()), missing_(p_.nodes.size()),
          uses_(p_.nodes.size()), users_(p_.nodes.size()), rest_(p_.nodes.size()), available_(p_.nodes.size()) {
        find_needed_nodes();
        for (int k = 0; k < int(p_.nodes.size()); ++k) {
            if (!needed_[std::size_t(k)]) continue;
            for (const int operand : distinct_operands(k)) {
                users_[std::size_t(operand)].push_back(k);
                ++missing_[std::size_t(k)];
                ++uses_[std::size_t(operand)];
            }
        }
        for (int k = int(p_.nodes.size()) - 1; k >= 0; --k) {
            if (!needed_[std::size_t(k)]) continue;
            double longest = 0;
            for (const int user : users_[std::size_t(k)]) longest = std::max(longest, rest_[std::size_t(user)]);
            rest_[std::size_t(k)] = longest + time_of(p_[k].op).latency;
            if (missing_[std::size_t(k)] == 0) ready_.push_back(k);
        }
    }
    std::vector<int> schedule() {
        std::vector<int> order;
        while (!ready_.empty()) {
            const std::size_t best = best_ready();
            const int k = ready_[best];
            ready_[best] = ready_.back();
            ready_.pop_back();
            evaluate(k);
            order.push_back(k);
        }
        return order;
    }

private:
    void find_needed_nodes() {
        for (const int output : p_.outputs) needed_[std::size_t(output)] = !is_leaf(p_[output].op);
        for (int k = int(p_.nodes.size()) - 1; k >= 0; --k)
            if (needed_[std::size_t(k)])
                for (const int operand : distinct_operands(k)) needed_[std::size_t(operand)] = true;
    }
    /// Returns the operands of a node without leaves, each once.
    std::vector<int> distinct_operands(int k) const {
        std::vector<int> list;
        for (const int operand : {p_[k].a, p_[k].b, p_[k].c})
            if (operand >= 0 && !is_leaf(p_[operand].op) && std::find(list.begin(), list.end(), operand) == list.end())
                list.push_back(operand);
        return list;
    }
    /// Returns the number of values that are no longer in use after the evaluation of node k.
    int ended_values(int k) const {
        int count = 0;
        for (const int operand : distinct_operands(k)) count += uses_[std::size_t(operand)] == 1;
        return count;
    }
    /// Returns the index of the best ready node. Nodes whose operands are available precede the others. If registers
    /// are scarce, the number of values that end precedes both.
    std::size_t best_ready() const {
        const bool scarce = live_ >= limit_;
        const auto rank = [&](int k) {
            const double wait = std::max(0.0, available_[std::size_t(k)] - now_);
            const int change = ended_values(k) - !users_[std::size_t(k)].empty();
            return std::array<double, 2>{scarce ? double(change) : 0.0, rest_[std::size_t(k)] - wait};
        };
        std::size_t best = 0;
        std::array<double, 2> best_rank = rank(ready_[0]);
        for (std::size_t i = 1; i < ready_.size(); ++i)
            if (const auto r = rank(ready_[i]); r > best_rank || (r == best_rank && ready_[i] < ready_[best])) {
                best = i;
                best_rank = r;
            }
        return best;
    }
    /// Marks node k as evaluated.
    void evaluate(int k) {
        const OperationTime time = time_of(p_[k].op);
        now_ = std::max(now_, available_[std::size_t(k)]) + time.issue;
        for (const int operand : distinct_operands(k))
            if (--uses_[std::size_t(operand)] == 0) --live_;
        if (!users_[std::size_t(k)].empty()) ++live_;
        for (const int user : users_[std::size_t(k)]) {
            double& available = available_[std::size_t(user)];
            available = std::max(available, now_ + time.latency);
            if (--missing_[std::size_t(user)] == 0) ready_.push_back(user);
        }
    }

    const UnrolledProgram& p_;
    const int limit_;                      ///< Greatest number of values in registers.
    std::vector<bool> needed_;             ///< Per node: an output needs it.
    std::vector<int> missing_, uses_;      ///< Per node: numbers of operands and users that are not yet evaluated.
    std::vector<std::vector<int>> users_;  ///< Per node: the nodes that use it.
    std::vector<double> rest_;             ///< Per node: time from its begin to the end of the program.
    std::vector<double> available_;        ///< Per node: time at which its operands are available.
    std::vector<int> ready_;
    double now_ = 0;
    int live_ = 0;
};

}  // namespace

UnrolledProgram::UnrolledProgram(const FunctionDescription& function) {
    const auto registers = int(function.type->registers), count = int(function.node_count);
    // Constants are the same for all registers.
    const auto moved = [&](int operand, int r) {
        return operand < 0 || function.nodes[operand].op == Op::constant ? operand : operand + r * count;
    };
    for (int r = 0; r < registers; ++r)
        for (int k = 0; k < count; ++k) {
            const ProgramNode& n = function.nodes[k];
            if (n.op == Op::input) nodes.push_back({n.op, n.a * registers + r, -1, -1, 0});
            else nodes.push_back({n.op, moved(n.a, r), moved(n.b, r), moved(n.c, r), n.value});
        }
    for (std::uint32_t o = 0; o < function.output_count; ++o)
        for (int r = 0; r < registers; ++r) outputs.push_back(moved(function.outputs[o], r));
}

std::vector<int> evaluation_order(const UnrolledProgram& program, int register_count) {
    return ListScheduler(program, register_count).schedule();
}

std::vector<std::vector<int>> uses_in_order(const UnrolledProgram& program, const std::vector<int>& order) {
    std::vector<std::vector<int>> uses(program.nodes.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const ProgramNode& n = program[order[i]];
        for (const int operand : {n.a, n.b, n.c}) {
            if (operand < 0) continue;
            std::vector<int>& list = uses[std::size_t(operand)];
            if (list.empty() || list.back() != int(i)) list.push_back(int(i));
        }
    }
    return uses;
}

}  // namespace kagero::compiler
