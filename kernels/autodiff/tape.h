/// Reverse-mode automatic differentiation at compile time.
///
/// A Hamiltonian is a generic function. If it is called with `Recorded` numbers (recorded.h) in a constant expression,
/// it records a tape: a list of operations whose operands are compile-time indices. The reverse sweep (gradient.h) is
/// recorded onto the same tape, so that value and derivatives share common subexpressions. Expressions are simplified
/// while they are recorded. `program.h` evaluates programs that are extracted from the tape.
///
/// Nodes that depend only on parameters and constants are `uniform`: they are evaluated once per job, not once per ray.
#pragma once

#include "kernels/operation.h"

#include <type_traits>

namespace kagero {

/// A node of a tape.
struct Node {
    Op op = Op::constant;
    int a = -1, b = -1, c = -1;  ///< Indices of the operands; −1: absent. In leaves, a is the index of the parameter or
                                 ///< input.
    double value = 0;            ///< Value of a constant.
    bool uniform = true;         ///< True if the node depends only on parameters and constants.
};

/// Returns op(a, b) at run time. It is defined in program.h.
inline double value_of(Op op, double a, double b);

/// The recorded operations. Functions that record an operation return the index of its node.
class Tape {
public:
    static constexpr int capacity = 768;
    Node nodes[capacity]{};
    int size = 0;
    bool full = false;  ///< True if the capacity was exceeded. Nodes that were recorded afterwards are invalid.

    constexpr int constant(double x) { return append({Op::constant, -1, -1, -1, x, true}); }
    constexpr int parameter(int i) { return append({Op::parameter, i, -1, -1, 0, true}); }
    constexpr int input(int i) { return append({Op::input, i, -1, -1, 0, false}); }

    constexpr int add(int a, int b) {
        if (is_constant(a, 0)) return b;
        if (is_constant(b, 0)) return a;
        if (both_constant(a, b)) return constant(nodes[a].value + nodes[b].value);
        if (a == b) return mul(constant(2), a);
        if (nodes[b].op == Op::neg) return sub(a, nodes[b].a);
        if (nodes[a].op == Op::neg) return sub(b, nodes[a].a);
        return append_sorted(Op::add, a, b);
    }
    constexpr int sub(int a, int b) {
        if (is_constant(b, 0)) return a;
        if (is_constant(a, 0)) return neg(b);
        if (a == b) return constant(0);
        if (both_constant(a, b)) return constant(nodes[a].value - nodes[b].value);
        if (nodes[b].op == Op::neg) return add(a, nodes[b].a);
        return append({Op::sub, a, b, -1, 0, uniform(a) && uniform(b)});
    }
    constexpr int mul(int a, int b) {
        if (is_constant(a, 0) || is_constant(b, 0)) return constant(0);
        if (is_constant(a, 1)) return b;
        if (is_constant(b, 1)) return a;
        if (is_constant(a, -1)) return neg(b);
        if (is_constant(b, -1)) return neg(a);
        if (both_constant(a, b)) return constant(nodes[a].value * nodes[b].value);
        if (nodes[a].op == Op::neg && !uniform(a)) return neg(mul(nodes[a].a, b));
        if (nodes[b].op == Op::neg && !uniform(b)) return neg(mul(a, nodes[b].a));
        if (const int product = product_of_roots(a, b); product >= 0) return product;
        // Uniform factors are moved outward and combined: u (v x) = (u v) x and (u x) y = u (x y).
        if (uniform(b) && !uniform(a)) return mul(b, a);
        if (const int inner = uniform_factor(b); inner >= 0 && uniform(a)) return mul(mul(a, inner), nodes[b].b);
        if (const int inner = uniform_factor(a); inner >= 0) return mul(inner, mul(nodes[a].b, b));
        if (const int inner = uniform_factor(b); inner >= 0) return mul(inner, mul(a, nodes[b].b));
        // If the terms of a sum have uniform factors, these absorb the factor u: u (v x + w y) = (u v) x + (u w) y.
        if (const Node s = nodes[b]; uniform(a) && (s.op == Op::add || s.op == Op::sub) && absorbs(s.a) && absorbs(s.b))
            return s.op == Op::add ? add(mul(a, s.a), mul(a, s.b)) : sub(mul(a, s.a), mul(a, s.b));
        return uniform(a) && !uniform(b) ? append({Op::mul, a, b, -1, 0, false}) : append_sorted(Op::mul, a, b);
    }
    constexpr int neg(int a) {
        if (nodes[a].op == Op::constant) return constant(-nodes[a].value);
        if (nodes[a].op == Op::neg) return nodes[a].a;
        if (nodes[a].op == Op::sub) return sub(nodes[a].b, nodes[a].a);
        if (const int inner = uniform_factor(a); inner >= 0) return mul(neg(inner), nodes[a].b);
        return unary(Op::neg, a);
    }
    constexpr int recip(int a) {
        if (nodes[a].op == Op::constant) return constant(1 / nodes[a].value);
        if (nodes[a].op == Op::recip) return nodes[a].a;
        if (const int rsqrt = reciprocal_root_of(a); rsqrt >= 0) return rsqrt;
        if (const int inner = uniform_factor(a); inner >= 0) return mul(recip(inner), recip(nodes[a].b));
        return unary(Op::recip, a);
    }
    constexpr int div(int a, int b) { return mul(a, recip(b)); }
    /// Records √s as s·(1/√s), so that √s and 1/√s share the reciprocal square root.
    constexpr int sqrt(int s) { return uniform(s) ? unary(Op::sqrt, s) : mul(s, unary(Op::rsqrt, s)); }
    /// Records a function of operation_table.h. The function has one operand if b < 0.
    constexpr int function(Op op, int a, int b = -1) {
        if (op == Op::recip) return recip(a);
        if (op == Op::sqrt) return sqrt(a);
        return b < 0 ? unary(op, a) : binary(op, a, b);
    }
    /// Records a function of one operand. A function of a constant is evaluated if the tape is recorded at run time. At
    /// compile time it is not evaluated, because the functions of the standard library are not constexpr.
    constexpr int unary(Op op, int a) {
        if (!std::is_constant_evaluated() && nodes[a].op == Op::constant)
            return constant(value_of(op, nodes[a].value, 0));
        return append({op, a, -1, -1, 0, uniform(a)});
    }
    /// Records a function of two operands. At run time, a function of constants is evaluated, except for `at_least`,
    /// which remains a uniform node.
    constexpr int binary(Op op, int a, int b) {
        if (!std::is_constant_evaluated() && op != Op::at_least && both_constant(a, b))
            return constant(value_of(op, nodes[a].value, nodes[b].value));
        return append({op, a, b, -1, 0, uniform(a) && uniform(b)});
    }

    constexpr bool uniform(int i) const { return nodes[i].uniform; }
    /// Returns the node 1/√s if node i is √s, recorded as s·(1/√s); else −1.
    constexpr int reciprocal_root_of(int i) const {
        const Node& n = nodes[i];
        if (n.op != Op::mul) return -1;
        if (nodes[n.b].op == Op::rsqrt && nodes[n.b].a == n.a) return n.b;
        if (nodes[n.a].op == Op::rsqrt && nodes[n.a].a == n.b) return n.a;
        return -1;
    }
    /// Appends a node without simplification. If a node with the same operation and operands exists, returns that node.
    constexpr int append(const Node& n) {
        int& last = n.a < 0 ? last_constant_ : last_user_[n.a];
        for (int i = last - 1; i >= 0; i = earlier_[i] - 1) {
            const Node& present = nodes[i];
            if (present.op == n.op && present.b == n.b && present.c == n.c && present.value == n.value) return i;
        }
        // At run time the tape of a scene's formula may become too long. At compile time the access below the check
        // would be a compilation error.
        if (size == capacity && !std::is_constant_evaluated()) return full = true, 0;
        nodes[size] = n;
        earlier_[size] = last;
        return last = ++size, size - 1;
    }

private:
    // Nodes with the same value of Node::a form a linked list, the last node first: last_user_[a] is the first element,
    // and earlier_[i] follows element i. Constants form a list of their own. Indices are stored plus 1; 0 ends a list.
    int last_user_[capacity]{}, earlier_[capacity]{};
    int last_constant_ = 0;

    /// Returns true if node i is the constant x.
    constexpr bool is_constant(int i, double x) const { return nodes[i].op == Op::constant && nodes[i].value == x; }
    constexpr bool both_constant(int a, int b) const {
        return nodes[a].op == Op::constant && nodes[b].op == Op::constant;
    }
    /// Returns the uniform factor u if node i is u·x with a nonuniform x, else −1.
    constexpr int uniform_factor(int i) const {
        const Node& n = nodes[i];
        return n.op == Op::mul && !n.uniform && nodes[n.a].uniform ? n.a : -1;
    }
    /// Returns true if node i can be multiplied by a uniform factor without an additional operation per ray.
    constexpr bool absorbs(int i) const { return uniform(i) || uniform_factor(i) >= 0; }
    /// Returns the node of a·b if it is √s·√s = s or √s·(1/√s) = 1; else −1.
    constexpr int product_of_roots(int a, int b) {
        const int rsqrt_a = reciprocal_root_of(a);
        if (a == b && rsqrt_a >= 0) return nodes[rsqrt_a].a;
        if (rsqrt_a >= 0 && b == rsqrt_a) return constant(1);
        if (const int rsqrt_b = reciprocal_root_of(b); rsqrt_b >= 0 && a == rsqrt_b) return constant(1);
        return -1;
    }
    /// Records a commutative operation with its operands in ascending order.
    constexpr int append_sorted(Op op, int a, int b) { return a < b ? binary(op, a, b) : binary(op, b, a); }
};

}  // namespace kagero
