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
    if (is_call(op)) return {60, 30};
    switch (op) {
        case Op::recip: return {27, 4};
        case Op::rsqrt: return {31, 5};
        case Op::sqrt: return {30, 6};
        case Op::min:
        case Op::max:
        case Op::at_least: return {10, 2};
        case Op::if_positive:
        case Op::unless_positive: return {14, 3};
        default: return {4, 0.5};
    }
}

/// List scheduling (Graham 1966) with a limit on the number of values in registers.
class ListScheduler {
public:
    ListScheduler(const UnrolledProgram& program, int register_count)
        : p_(program), limit_(register_count), nodes_(std::size_t(program.size())) {
        for (int k = 0; k < p_.size(); ++k) {
            if (!p_.is_needed(k) || is_leaf(p_[k].op) || p_.representative(k) != k) continue;
            for (const int operand : p_.operands(k))
                if (!is_leaf(p_[operand].op)) node(k).operands.push_back(operand);
            for (const int operand : node(k).operands) node(operand).users.push_back(k);
            node(k).missing = int(node(k).operands.size());
            if (node(k).missing == 0) ready_.push_back(k);
        }
        for (Node& n : nodes_) n.uses = int(n.users.size());
        find_remaining_times();
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
    struct Node {
        std::vector<int> operands, users;  ///< Without leaves; users are representatives.
        int missing = 0, uses = 0;         ///< Numbers of operands and users that are not yet evaluated.
        double remaining = 0;              ///< Time from the begin of the node to the end of the program.
        double available = 0;              ///< Time at which its operands are available.
    };
    Node& node(int k) { return nodes_[std::size_t(k)]; }
    const Node& node(int k) const { return nodes_[std::size_t(k)]; }

    /// Computes `remaining`, from the last node of a topological order to the first.
    void find_remaining_times() {
        std::vector<int> order = ready_, missing(nodes_.size());
        for (std::size_t k = 0; k < nodes_.size(); ++k) missing[k] = nodes_[k].missing;
        for (std::size_t i = 0; i < order.size(); ++i)
            for (const int member : p_.evaluated_with(order[i]))
                for (const int user : node(member).users)
                    if (--missing[std::size_t(user)] == 0) order.push_back(user);
        for (auto k = order.rbegin(); k != order.rend(); ++k) {
            double longest = 0;
            for (const int member : p_.evaluated_with(*k))
                for (const int user : node(member).users) longest = std::max(longest, node(user).remaining);
            node(*k).remaining = longest + time_of(p_[*k].op).latency;
        }
    }
    /// Returns the increase of the number of values in use by the evaluation of node k.
    int additional_values(int k) const {
        int count = 0;
        if (p_.call(k)) return 0;  // the results are in memory
        for (const int operand : node(k).operands) count -= node(operand).uses == 1;
        return count + !node(k).users.empty();
    }
    /// Returns the index of the best ready node. Nodes whose operands are available precede the others. If registers
    /// are scarce, the number of values in use precedes both.
    std::size_t best_ready() const {
        const bool scarce = live_ >= limit_;
        const auto rank = [&](int k) {
            const double wait = std::max(0.0, node(k).available - now_);
            return std::array<double, 2>{scarce ? -double(additional_values(k)) : 0.0, node(k).remaining - wait};
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
    /// Marks node k, and those that are evaluated with it, as evaluated.
    void evaluate(int k) {
        const OperationTime time = time_of(p_[k].op);
        now_ = std::max(now_, node(k).available) + time.issue;
        for (const int operand : node(k).operands)
            if (--node(operand).uses == 0) --live_;
        for (const int member : p_.evaluated_with(k)) {
            if (!node(member).users.empty()) ++live_;
            for (const int user : node(member).users) {
                node(user).available = std::max(node(user).available, now_ + time.latency);
                if (--node(user).missing == 0) ready_.push_back(user);
            }
        }
    }

    const UnrolledProgram& p_;
    const int limit_;  ///< Greatest number of values in registers.
    std::vector<Node> nodes_;
    std::vector<int> ready_;
    double now_ = 0;
    int live_ = 0;
};

}  // namespace

std::vector<int> evaluation_order(const UnrolledProgram& program, int register_count) {
    return ListScheduler(program, register_count).schedule();
}

std::vector<std::vector<int>> uses_in_order(const UnrolledProgram& program, const std::vector<int>& order) {
    std::vector<std::vector<int>> uses(std::size_t(program.size()));
    for (std::size_t i = 0; i < order.size(); ++i)
        for (const int operand : program.operands(order[i])) uses[std::size_t(operand)].push_back(int(i));
    return uses;
}

}  // namespace kagero::compiler
