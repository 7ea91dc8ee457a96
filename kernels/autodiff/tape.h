/// Reverse-mode automatic differentiation at compile time.
///
/// A Hamiltonian is a generic function. Called in a constant expression with `Recorded` numbers (recorded.h), it leaves
/// behind a tape: a list of operations whose operands are compile-time indices. The reverse sweep (gradient.h) is
/// recorded onto the same tape, so value and derivatives share what they have in common; simplification happens as
/// nodes are pushed. `program.h` turns the tape into straight-line code.
///
/// Nodes that depend on parameters and constants alone are `uniform`: they are evaluated once per job, not once per
/// ray.
#pragma once

#include "kernels/operation.h"

#include <type_traits>

namespace kagero {

struct Node {
    Op op = Op::constant;
    int a = -1, b = -1, c = -1;  ///< operands; for leaves a is the index of the parameter or input
    double value = 0;            ///< constants only
    bool uniform = true;
};

/// An operation on numbers while the program runs (program.h).
inline double value_of(Op op, double a, double b);

class Tape {
public:
    static constexpr int capacity = 768;
    Node nodes[capacity]{};
    int size = 0;
    bool full = false;  ///< a node had no room: whatever was recorded since is meaningless

    constexpr int constant(double x) { return append({Op::constant, -1, -1, -1, x, true}); }
    constexpr int parameter(int i) { return append({Op::parameter, i, -1, -1, 0, true}); }
    constexpr int input(int i) { return append({Op::input, i, -1, -1, 0, false}); }

    constexpr int add(int a, int b) {
        if (is(a, 0)) return b;
        if (is(b, 0)) return a;
        if (both_constant(a, b)) return constant(nodes[a].value + nodes[b].value);
        if (a == b) return mul(constant(2), a);
        if (nodes[b].op == Op::neg) return sub(a, nodes[b].a);
        if (nodes[a].op == Op::neg) return sub(b, nodes[a].a);
        return append_sorted(Op::add, a, b);
    }
    constexpr int sub(int a, int b) {
        if (is(b, 0)) return a;
        if (is(a, 0)) return neg(b);
        if (a == b) return constant(0);
        if (both_constant(a, b)) return constant(nodes[a].value - nodes[b].value);
        if (nodes[b].op == Op::neg) return add(a, nodes[b].a);
        return append({Op::sub, a, b, -1, 0, uniform(a) && uniform(b)});
    }
    constexpr int mul(int a, int b) {
        if (is(a, 0) || is(b, 0)) return constant(0);
        if (is(a, 1)) return b;
        if (is(b, 1)) return a;
        if (is(a, -1)) return neg(b);
        if (is(b, -1)) return neg(a);
        if (both_constant(a, b)) return constant(nodes[a].value * nodes[b].value);
        if (nodes[a].op == Op::neg && !uniform(a)) return neg(mul(nodes[a].a, b));
        if (nodes[b].op == Op::neg && !uniform(b)) return neg(mul(a, nodes[b].a));
        if (const int root = square_root_cancelled(a, b); root >= 0) return root;
        // Uniform factors travel outward and meet: u (v x) = (u v) x, (u x) y = u (x y).
        if (uniform(b) && !uniform(a)) return mul(b, a);
        if (const int inner = scaled(b); inner >= 0 && uniform(a)) return mul(mul(a, inner), nodes[b].b);
        if (const int inner = scaled(a); inner >= 0) return mul(inner, mul(nodes[a].b, b));
        if (const int inner = scaled(b); inner >= 0) return mul(inner, mul(a, nodes[b].b));
        // Into sums whose terms have uniform factors already: u (v x + w y) = (u v) x + (u w) y.
        if (const Node s = nodes[b]; uniform(a) && (s.op == Op::add || s.op == Op::sub) && absorbs(s.a) && absorbs(s.b))
            return s.op == Op::add ? add(mul(a, s.a), mul(a, s.b)) : sub(mul(a, s.a), mul(a, s.b));
        return uniform(a) && !uniform(b) ? append({Op::mul, a, b, -1, 0, false}) : append_sorted(Op::mul, a, b);
    }
    constexpr int neg(int a) {
        if (nodes[a].op == Op::constant) return constant(-nodes[a].value);
        if (nodes[a].op == Op::neg) return nodes[a].a;
        if (nodes[a].op == Op::sub) return sub(nodes[a].b, nodes[a].a);
        if (const int inner = scaled(a); inner >= 0) return mul(neg(inner), nodes[a].b);
        return unary(Op::neg, a);
    }
    constexpr int recip(int a) {
        if (nodes[a].op == Op::constant) return constant(1 / nodes[a].value);
        if (nodes[a].op == Op::recip) return nodes[a].a;
        if (const int root = root_of(a); root >= 0) return root;
        if (const int inner = scaled(a); inner >= 0) return mul(recip(inner), recip(nodes[a].b));
        return unary(Op::recip, a);
    }
    constexpr int div(int a, int b) { return mul(a, recip(b)); }
    /// √s as s·(1/√s), so that √s and 1/√s share their expensive half.
    constexpr int sqrt(int s) { return uniform(s) ? unary(Op::sqrt, s) : mul(s, unary(Op::rsqrt, s)); }
    /// A function of the table, of one operand where b < 0.
    constexpr int function(Op op, int a, int b = -1) {
        if (op == Op::recip) return recip(a);
        if (op == Op::sqrt) return sqrt(a);
        return b < 0 ? unary(op, a) : binary(op, a, b);
    }
    /// Functions of numbers are numbers, where the standard library can tell them: while the program runs.
    constexpr int unary(Op op, int a) {
        if (!std::is_constant_evaluated() && nodes[a].op == Op::constant)
            return constant(value_of(op, nodes[a].value, 0));
        return append({op, a, -1, -1, 0, uniform(a)});
    }
    constexpr int binary(Op op, int a, int b) {
        if (!std::is_constant_evaluated() && op != Op::at_least && both_constant(a, b))
            return constant(value_of(op, nodes[a].value, nodes[b].value));
        return append({op, a, b, -1, 0, uniform(a) && uniform(b)});
    }

    constexpr bool uniform(int i) const { return nodes[i].uniform; }
    /// The node 1/√s when node i is √s, written s·(1/√s); else −1.
    constexpr int root_of(int i) const {
        const Node& n = nodes[i];
        if (n.op != Op::mul) return -1;
        if (nodes[n.b].op == Op::rsqrt && nodes[n.b].a == n.a) return n.b;
        if (nodes[n.a].op == Op::rsqrt && nodes[n.a].a == n.b) return n.a;
        return -1;
    }
    /// Appends as it is, or finds the same operation that is already there.
    constexpr int append(const Node& n) {
        int& last = n.a < 0 ? last_constant_ : last_user_[n.a];
        for (int i = last - 1; i >= 0; i = earlier_[i] - 1) {
            const Node& o = nodes[i];
            if (o.op == n.op && o.b == n.b && o.c == n.c && o.value == n.value) return i;
        }
        // The compiler stops at the end of the array by itself; formulas of a scene are recorded while the program
        // runs.
        if (size == capacity && !std::is_constant_evaluated()) return full = true, 0;
        nodes[size] = n;
        earlier_[size] = last;
        return last = ++size, size - 1;
    }

private:
    // Nodes of the same first operand (or leaf's index, or none) are chained, the last first; counted from 1, as 0 ends
    // a chain.
    int last_user_[capacity]{}, earlier_[capacity]{};
    int last_constant_ = 0;

    constexpr bool is(int i, double x) const { return nodes[i].op == Op::constant && nodes[i].value == x; }
    constexpr bool both_constant(int a, int b) const {
        return nodes[a].op == Op::constant && nodes[b].op == Op::constant;
    }
    /// The uniform factor u when node i is u·x with x varying, else −1.
    constexpr int scaled(int i) const {
        const Node& n = nodes[i];
        return n.op == Op::mul && !n.uniform && nodes[n.a].uniform ? n.a : -1;
    }
    /// Whether a uniform factor of node i costs nothing.
    constexpr bool absorbs(int i) const { return uniform(i) || scaled(i) >= 0; }
    /// √s·√s = s and √s·(1/√s) = 1; −1 when neither is there.
    constexpr int square_root_cancelled(int a, int b) {
        const int root = root_of(a);
        if (a == b && root >= 0) return nodes[root].a;
        if (root >= 0 && b == root) return constant(1);
        if (const int other = root_of(b); other >= 0 && a == other) return constant(1);
        return -1;
    }
    constexpr int append_sorted(Op op, int a, int b) { return a < b ? binary(op, a, b) : binary(op, b, a); }
};

}  // namespace kagero
