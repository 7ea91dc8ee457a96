/// Reverse-mode automatic differentiation at compile time.
///
/// A Hamiltonian is a generic function. Called in a constant expression with `Recorded` numbers it leaves behind a tape: a list of
/// operations whose operands are compile-time indices. The reverse sweep is recorded onto the same tape, so value and derivatives
/// share what they have in common; simplification happens as nodes are pushed. `program.h` turns the tape into straight-line code.
///
/// Nodes that depend on parameters and constants alone are `uniform`: they are evaluated once per job, not once per ray.
#pragma once

#include <array>
#include <cmath>
#include <type_traits>

namespace kagero {

enum class Op : unsigned char {
    constant, parameter, input,  // leaves: a number, a parameter of H, a variable of the ray
    add, sub, mul, neg, recip, sqrt, rsqrt,
    exp, log, sin, cos, tan, tanh, atan2, min, max, at_least,  // at_least(a, b) = 1 where a >= b, else 0
    mul_add, mul_sub, neg_mul_add,                      // a·b + c, a·b − c, c − a·b
};

/// Calls a macro with every operation that is no leaf.
#define KAGERO_OPERATIONS(X)                                                                                          \
    X(add) X(sub) X(mul) X(neg) X(recip) X(sqrt) X(rsqrt) X(exp) X(log) X(sin) X(cos) X(tan) X(tanh) X(atan2) X(min)   \
    X(max) X(at_least) X(mul_add) X(mul_sub) X(neg_mul_add)

/// Of the standard library, that is.
constexpr bool is_function(Op op) { return op >= Op::exp && op <= Op::atan2; }

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
    /// Functions of numbers are numbers, where the standard library can tell them: while the program runs.
    constexpr int unary(Op op, int a) {
        if (!std::is_constant_evaluated() && nodes[a].op == Op::constant) return constant(value_of(op, nodes[a].value, 0));
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
        // The compiler stops at the end of the array by itself; formulas of a scene are recorded while the program runs.
        if (size == capacity && !std::is_constant_evaluated()) return full = true, 0;
        nodes[size] = n;
        earlier_[size] = last;
        return last = ++size, size - 1;
    }

private:
    // Nodes of the same first operand (or leaf's index, or none) are chained, the last first; counted from 1, as 0 ends a chain.
    int last_user_[capacity]{}, earlier_[capacity]{};
    int last_constant_ = 0;

    constexpr bool is(int i, double x) const { return nodes[i].op == Op::constant && nodes[i].value == x; }
    constexpr bool both_constant(int a, int b) const { return nodes[a].op == Op::constant && nodes[b].op == Op::constant; }
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

/// A number that writes down what is done to it.
struct Recorded {
    Tape* tape = nullptr;
    int node = -1;
    double value = 0;  ///< while it is a constant of no tape yet

    constexpr Recorded() = default;
    constexpr Recorded(double x) : value(x) {}
    constexpr Recorded(Tape* t, int n) : tape(t), node(n) {}
    constexpr int on(Tape& t) const { return tape ? node : t.constant(value); }
};

#define KAGERO_RECORD_BINARY(NAME, CALL, PLAIN)                             \
    constexpr Recorded NAME(const Recorded& a, const Recorded& b) {         \
        Tape* t = a.tape ? a.tape : b.tape;                                 \
        if (!t) return PLAIN;                                               \
        const int i = a.on(*t), j = b.on(*t);                               \
        return {t, t->CALL};                                                \
    }
KAGERO_RECORD_BINARY(operator+, add(i, j), a.value + b.value)
KAGERO_RECORD_BINARY(operator-, sub(i, j), a.value - b.value)
KAGERO_RECORD_BINARY(operator*, mul(i, j), a.value * b.value)
KAGERO_RECORD_BINARY(operator/, div(i, j), a.value / b.value)
KAGERO_RECORD_BINARY(atan2, binary(Op::atan2, i, j), std::atan2(a.value, b.value))
KAGERO_RECORD_BINARY(min, binary(Op::min, i, j), a.value < b.value ? a.value : b.value)
KAGERO_RECORD_BINARY(max, binary(Op::max, i, j), a.value > b.value ? a.value : b.value)
#undef KAGERO_RECORD_BINARY

#define KAGERO_RECORD_UNARY(NAME, CALL) \
    constexpr Recorded NAME(const Recorded& a) { return {a.tape, a.tape->CALL}; }
KAGERO_RECORD_UNARY(operator-, neg(a.node))
KAGERO_RECORD_UNARY(sqrt, sqrt(a.node))
KAGERO_RECORD_UNARY(exp, unary(Op::exp, a.node))
KAGERO_RECORD_UNARY(log, unary(Op::log, a.node))
KAGERO_RECORD_UNARY(sin, unary(Op::sin, a.node))
KAGERO_RECORD_UNARY(cos, unary(Op::cos, a.node))
KAGERO_RECORD_UNARY(tan, unary(Op::tan, a.node))
KAGERO_RECORD_UNARY(tanh, unary(Op::tanh, a.node))
#undef KAGERO_RECORD_UNARY

/// What an operation at node i of the tape hands on to its operands of its own derivative, node d: `give(operand, amount)`.
template <class Give>
constexpr void give_operands(Tape& t, int i, int d, const Give& give) {
    const Node n = t.nodes[i];
    switch (n.op) {
        case Op::add: give(n.a, d), give(n.b, d); break;
        case Op::sub: give(n.a, d), give(n.b, t.neg(d)); break;
        case Op::mul:
            if (const int root = t.root_of(i); root >= 0) {
                // √s, written s·(1/√s): half of 1/√s, not a difference of two large terms.
                give(t.nodes[root].a, t.mul(t.constant(0.5), t.mul(d, root)));
            } else if (n.a == n.b) {
                give(n.a, t.mul(t.mul(t.constant(2), d), n.a));
            } else {
                give(n.a, t.mul(d, n.b)), give(n.b, t.mul(d, n.a));
            }
            break;
        case Op::neg: give(n.a, t.neg(d)); break;
        case Op::recip: give(n.a, t.neg(t.mul(d, t.mul(i, i)))); break;
        case Op::rsqrt: give(n.a, t.mul(t.constant(-0.5), t.mul(t.mul(d, i), t.mul(i, i)))); break;
        case Op::sqrt: give(n.a, t.mul(t.constant(0.5), t.mul(d, t.recip(i)))); break;
        case Op::exp: give(n.a, t.mul(d, i)); break;
        case Op::log: give(n.a, t.mul(d, t.recip(n.a))); break;
        case Op::sin: give(n.a, t.mul(d, t.unary(Op::cos, n.a))); break;
        case Op::cos: give(n.a, t.neg(t.mul(d, t.unary(Op::sin, n.a)))); break;
        case Op::tan: give(n.a, t.mul(d, t.add(t.constant(1), t.mul(i, i)))); break;
        case Op::tanh: give(n.a, t.mul(d, t.sub(t.constant(1), t.mul(i, i)))); break;
        case Op::atan2: {
            const int over = t.mul(d, t.recip(t.add(t.mul(n.a, n.a), t.mul(n.b, n.b))));
            give(n.a, t.mul(over, n.b)), give(n.b, t.neg(t.mul(over, n.a)));
            break;
        }
        case Op::min: {
            const int first = t.binary(Op::at_least, n.b, n.a);
            give(n.a, t.mul(d, first)), give(n.b, t.mul(d, t.sub(t.constant(1), first)));
            break;
        }
        case Op::max: {
            const int first = t.binary(Op::at_least, n.a, n.b);
            give(n.a, t.mul(d, first)), give(n.b, t.mul(d, t.sub(t.constant(1), first)));
            break;
        }
        default: break;  // leaves and steps have no derivative; fused operations appear only after recording
    }
}

/// Adds to the tape the derivatives of node `output` with respect to the leaves `wanted`; `gradient[k]` receives their nodes.
/// Branches that do not reach a wanted leaf cost nothing.
template <int N>
constexpr void record_gradient(Tape& t, int output, const std::array<int, N>& wanted, std::array<int, N>& gradient) {
    const int last = output;
    bool reaches[Tape::capacity]{};
    int adjoint[Tape::capacity]{};
    for (int i = 0; i <= last; ++i) {
        const Node& n = t.nodes[i];
        if (n.op == Op::input) {
            for (int w : wanted) reaches[i] = reaches[i] || w == i;
        } else if (!n.uniform) {
            reaches[i] = reaches[n.a] || (n.b >= 0 && reaches[n.b]);
        }
        adjoint[i] = -1;
    }
    const auto give = [&](int to, int amount) {
        if (reaches[to]) adjoint[to] = adjoint[to] < 0 ? amount : t.add(adjoint[to], amount);
    };
    adjoint[last] = t.constant(1);
    for (int i = last; i >= 0; --i) {
        const int d = adjoint[i];
        if (d < 0 || !reaches[i]) continue;
        give_operands(t, i, d, give);
    }
    for (int k = 0; k < N; ++k) gradient[k] = adjoint[wanted[k]] < 0 ? t.constant(0) : adjoint[wanted[k]];
}

/// The node of g·h with g multiplied through: distributed over sums that have a term with the factor 1/g, where it cancels.
constexpr int multiply_through(Tape& t, int g, int h) {
    const int one_over = t.recip(g);
    const auto factor = [&](auto&& self, int i) -> bool {
        const Node& n = t.nodes[i];
        return i == one_over || (n.op == Op::mul && (self(self, n.a) || self(self, n.b)));
    };
    const auto term = [&](auto&& self, int i) -> bool {
        const Node& n = t.nodes[i];
        if (n.op == Op::neg) return self(self, n.a);
        if (n.op == Op::add || n.op == Op::sub) return self(self, n.a) || self(self, n.b);
        return factor(factor, i);
    };
    const Node n = t.nodes[h];
    if (h == one_over) return t.constant(1);
    if (!term(term, h)) return t.mul(g, h);
    switch (n.op) {
        case Op::add: return t.add(multiply_through(t, g, n.a), multiply_through(t, g, n.b));
        case Op::sub: return t.sub(multiply_through(t, g, n.a), multiply_through(t, g, n.b));
        case Op::neg: return t.neg(multiply_through(t, g, n.a));
        default: break;  // a product
    }
    return factor(factor, n.a) ? t.mul(multiply_through(t, g, n.a), n.b) : t.mul(n.a, multiply_through(t, g, n.b));
}

}  // namespace kagero
