/// Straight-line programs: what is left of a tape when only some of its nodes are wanted.
///
/// `extract` drops what the outputs do not need, fuses products into sums, and numbers the rest. `run` unrolls the program over a
/// value type V by an index sequence: every operand is a compile-time index, so the compiler sees plain expressions.
#pragma once

#include "kernels/numeric/circular.h"
#include "kernels/numeric/tape.h"

#include <algorithm>
#include <utility>

namespace kagero {

template <int Size, int Outputs>
struct Program {
    std::array<Node, Size> nodes{};  ///< in order of evaluation; operands are indices into this array
    std::array<int, Size> slot{};    ///< of a uniform node in the table of uniforms, else −1
    std::array<int, Outputs> outputs{};
    int size = 0;
    int uniforms = 0;
    bool whole = true;  ///< else a tape was too short to arrange it on
    /// Whether an input in [first, last) occurs.
    constexpr bool uses_any_input(int first, int last) const {
        for (int k = 0; k < size; ++k)
            if (nodes[k].op == Op::input && nodes[k].a >= first && nodes[k].a < last) return true;
        return false;
    }
    /// Sines and cosines enough to be called rather than unrolled: a sum of many waves.
    constexpr bool calls_circular() const {
        int count = 0;
        for (int k = 0; k < size; ++k) count += !nodes[k].uniform && (nodes[k].op == Op::sin || nodes[k].op == Op::cos);
        return count > 4;
    }
    /// Its size, a called function counting as the many operations that it is.
    constexpr int length() const {
        int sum = size;
        for (int k = 0; k < size; ++k) sum += !nodes[k].uniform && is_function(nodes[k].op) ? 40 : 0;
        return sum;
    }
    /// How many parameters it reads, counted to the last of them.
    constexpr int parameters() const {
        int count = 0;
        for (int k = 0; k < size; ++k)
            if (nodes[k].op == Op::parameter && nodes[k].a >= count) count = nodes[k].a + 1;
        return count;
    }
    /// Whether output k is 0, whatever the inputs.
    constexpr bool returns_zero(int k) const {
        const Node& n = nodes[outputs[k]];
        return n.op == Op::constant && n.value == 0;
    }
    /// Whether output k is input i itself.
    constexpr bool returns_input(int k, int i) const {
        const Node& n = nodes[outputs[k]];
        return n.op == Op::input && n.a == i;
    }
};

/// What a program is called with again and again while the rest of its inputs stay: inputs in [first, last).
struct Varying {
    int first = 0, last = 1 << 30;
};

namespace detail {

constexpr bool is_leaf(Op op) { return op == Op::constant || op == Op::parameter || op == Op::input; }

/// A node whose operands have moved to other places.
constexpr Node moved(Node n, const std::array<int, Tape::capacity>& place) {
    if (is_leaf(n.op)) return n;
    n.a = place[n.a];
    if (n.b >= 0) n.b = place[n.b];
    if (n.c >= 0) n.c = place[n.c];
    return n;
}

template <int Outputs>
constexpr std::array<int, Tape::capacity> count_uses(const Tape& t, const std::array<int, Outputs>& outputs) {
    std::array<int, Tape::capacity> uses{};
    for (int o : outputs) ++uses[o];
    for (int i = t.size - 1; i >= 0; --i) {
        const Node& n = t.nodes[i];
        if (uses[i] == 0 || is_leaf(n.op)) continue;
        for (int operand : {n.a, n.b, n.c})
            if (operand >= 0) ++uses[operand];
    }
    return uses;
}

/// Uniform factors travel inward where that lets several products share one: u (d x), u (d y) become (u d) x, (u d) y.
template <int Outputs>
constexpr Tape share_scaled(const Tape& t, std::array<int, Outputs>& outputs) {
    const auto uses = count_uses<Outputs>(t, outputs);
    const auto scaled_product = [&](int i) {
        const Node& n = t.nodes[i];
        return uses[i] > 0 && n.op == Op::mul && !n.uniform && t.uniform(n.a) && t.nodes[n.b].op == Op::mul && uses[n.b] == 1;
    };
    /// How many products would share u·d.
    const auto shared_by = [&](int u, int d) {
        int count = 0;
        for (int i = 0; i < t.size; ++i) {
            if (!scaled_product(i) || t.nodes[i].a != u) continue;
            const Node& product = t.nodes[t.nodes[i].b];
            if (product.a == d || product.b == d) ++count;
        }
        return count;
    };
    Tape shared;
    std::array<int, Tape::capacity> place{};
    for (int i = 0; i < t.size; ++i) {
        const Node& n = t.nodes[i];
        if (uses[i] == 0 && n.op != Op::input) continue;
        if (scaled_product(i)) {
            const Node& product = t.nodes[n.b];
            const int with_a = shared_by(n.a, product.a), with_b = shared_by(n.a, product.b);
            if (with_a > 1 || with_b > 1) {
                const int d = with_a >= with_b ? product.a : product.b, x = with_a >= with_b ? product.b : product.a;
                const int factor = shared.append({Op::mul, place[n.a], place[d], -1, 0, false});
                place[i] = shared.append({Op::mul, factor, place[x], -1, 0, false});
                continue;
            }
        }
        place[i] = shared.append(moved(n, place));
    }
    for (int& o : outputs) o = place[o];
    return shared;
}

/// Reorders products: factors that stay meet first, and are multiplied once for many calls; of the others those that are known
/// earliest, so that no product waits longer than its last factor.
template <int Outputs>
constexpr Tape order_products(const Tape& t, std::array<int, Outputs>& outputs, Varying varying) {
    const auto uses = count_uses<Outputs>(t, outputs);
    std::array<int, Tape::capacity> depth{};  // operations on the way from the varying inputs; −1 where nothing varies
    std::array<bool, Tape::capacity> inner{}; // a product whose only use is another product
    for (int i = 0; i < t.size; ++i) {
        const Node& n = t.nodes[i];
        if (is_leaf(n.op)) {
            depth[i] = n.op == Op::input && n.a >= varying.first && n.a < varying.last ? 0 : -1;
            continue;
        }
        depth[i] = std::max({depth[n.a], n.b < 0 ? -1 : depth[n.b], n.c < 0 ? -1 : depth[n.c]});
        if (depth[i] >= 0) depth[i] += n.op == Op::rsqrt || n.op == Op::recip ? 6 : 1;
        if (uses[i] == 0 || n.op != Op::mul || depth[i] < 0) continue;
        for (int operand : {n.a, n.b})
            inner[operand] = inner[operand] || (t.nodes[operand].op == Op::mul && uses[operand] == 1 && depth[operand] >= 0);
    }
    Tape ordered;
    std::array<int, Tape::capacity> place{}, factors{};
    for (int i = 0; i < t.size; ++i) {
        const Node& n = t.nodes[i];
        if ((uses[i] == 0 && n.op != Op::input) || inner[i]) continue;
        if (n.op == Op::mul && depth[i] >= 0) {
            int count = 0;
            const auto gather = [&](auto&& self, int k) -> void {
                if (inner[k]) self(self, t.nodes[k].a), self(self, t.nodes[k].b);
                else factors[count++] = k;
            };
            gather(gather, n.a), gather(gather, n.b);
            const auto earlier = [&](int a, int b) {
                return t.uniform(a) != t.uniform(b) ? t.uniform(a) : depth[a] != depth[b] ? depth[a] < depth[b] : a < b;
            };
            std::sort(factors.begin(), factors.begin() + count, earlier);
            int product = place[factors[0]];
            for (int f = 1; f < count; ++f) {
                const int factor = place[factors[f]];
                product = ordered.append({Op::mul, product, factor, -1, 0, ordered.uniform(product) && ordered.uniform(factor)});
            }
            place[i] = product;
            continue;
        }
        place[i] = ordered.append(moved(n, place));
    }
    for (int& o : outputs) o = place[o];
    return ordered;
}

/// a·b + c in one operation wherever the product has no other use.
constexpr void fuse(Tape& t, const std::array<int, Tape::capacity>& uses) {
    for (int i = 0; i < t.size; ++i) {
        Node& n = t.nodes[i];
        if (n.uniform || uses[i] == 0 || (n.op != Op::add && n.op != Op::sub)) continue;
        const auto lone_product = [&](int k) { return t.nodes[k].op == Op::mul && !t.uniform(k) && uses[k] == 1; };
        if (lone_product(n.b)) {
            const Node product = t.nodes[n.b];
            n = {n.op == Op::add ? Op::mul_add : Op::neg_mul_add, product.a, product.b, n.a, 0, false};
        } else if (lone_product(n.a)) {
            const Node product = t.nodes[n.a];
            n = {n.op == Op::add ? Op::mul_add : Op::mul_sub, product.a, product.b, n.b, 0, false};
        }
    }
}

template <int Outputs>
constexpr Program<Tape::capacity, Outputs> extract_all(const Tape& recorded, std::array<int, Outputs> outputs, Varying varying = {}) {
    Tape t = share_scaled<Outputs>(recorded, outputs);
    const bool shared = !t.full;
    t = order_products<Outputs>(t, outputs, varying);
    fuse(t, count_uses<Outputs>(t, outputs));
    const auto uses = count_uses<Outputs>(t, outputs);
    Program<Tape::capacity, Outputs> p;
    p.whole = shared && !t.full;
    std::array<int, Tape::capacity> place{};
    for (int i = 0; i < t.size; ++i) {
        if (uses[i] == 0) continue;
        const Node n = moved(t.nodes[i], place);
        place[i] = p.size;
        p.slot[p.size] = n.uniform && n.op != Op::constant ? p.uniforms++ : -1;
        p.nodes[p.size++] = n;
    }
    for (int k = 0; k < Outputs; ++k) p.outputs[k] = place[outputs[k]];
    return p;
}

}  // namespace detail

/// The program that computes the given nodes of `recording.tape`, arranged for calls that change the `varying` inputs.
template <const auto& recording, auto outputs, Varying varying = Varying{}>
consteval auto extract() {
    constexpr auto all = detail::extract_all<static_cast<int>(outputs.size())>(recording.tape, outputs, varying);
    Program<all.size, static_cast<int>(outputs.size())> p;
    for (int i = 0; i < all.size; ++i) {
        p.nodes[i] = all.nodes[i];
        p.slot[i] = all.slot[i];
    }
    p.outputs = all.outputs;
    p.size = all.size;
    p.uniforms = all.uniforms;
    return p;
}

namespace detail {

template <class Function, class V>
__attribute__((noinline)) V outlined(const Function& function, const V& x) { return function(x); }

/// One operation on any number type.
template <Op op, bool call, class V>
KAGERO_INLINE V apply(const V& a, const V& b, const V& c) {
    if constexpr (op == Op::add) return a + b;
    else if constexpr (op == Op::sub) return a - b;
    else if constexpr (op == Op::mul) return a * b;
    else if constexpr (op == Op::neg) return -a;
    else if constexpr (op == Op::recip) return recip(a);
    else if constexpr (op == Op::sqrt) return sqrt(a);
    else if constexpr (op == Op::rsqrt) return rsqrt(a);
    else if constexpr (op == Op::exp) return exp(a);
    else if constexpr (op == Op::log) return log(a);
    else if constexpr (op == Op::sin && call) return outlined([](const V& x) { return sin(x); }, a);
    else if constexpr (op == Op::cos && call) return outlined([](const V& x) { return cos(x); }, a);
    else if constexpr (op == Op::sin) return sin(a);
    else if constexpr (op == Op::cos) return cos(a);
    else if constexpr (op == Op::tan) return tan(a);
    else if constexpr (op == Op::tanh) return tanh(a);
    else if constexpr (op == Op::atan2) return atan2(a, b);
    else if constexpr (op == Op::min) return min(a, b);
    else if constexpr (op == Op::max) return max(a, b);
    else if constexpr (op == Op::at_least) return pick(a >= b, V(1.0), V(0.0));
    else if constexpr (op == Op::mul_add) return mul_add(a, b, c);
    else if constexpr (op == Op::mul_sub) return mul_sub(a, b, c);
    else if constexpr (op == Op::neg_mul_add) return neg_mul_add(a, b, c);
}

/// op(a, b, c), of an operation that is no leaf.
template <class V>
V applied(Op op, const V& a, const V& b, const V& c) {
    switch (op) {
#define KAGERO_OPERATION(OP) \
    case Op::OP: return apply<Op::OP, false, V>(a, b, c);
        KAGERO_OPERATION(add) KAGERO_OPERATION(sub) KAGERO_OPERATION(mul) KAGERO_OPERATION(neg) KAGERO_OPERATION(recip)
        KAGERO_OPERATION(sqrt) KAGERO_OPERATION(rsqrt) KAGERO_OPERATION(exp) KAGERO_OPERATION(log) KAGERO_OPERATION(sin)
        KAGERO_OPERATION(cos) KAGERO_OPERATION(tan) KAGERO_OPERATION(tanh) KAGERO_OPERATION(atan2) KAGERO_OPERATION(min)
        KAGERO_OPERATION(max) KAGERO_OPERATION(at_least) KAGERO_OPERATION(mul_add) KAGERO_OPERATION(mul_sub) KAGERO_OPERATION(neg_mul_add)
#undef KAGERO_OPERATION
        default: return a;
    }
}

template <const auto& P>
inline constexpr bool calls_circular = P.calls_circular();

template <const auto& P, int I, class V, class S>
KAGERO_INLINE void evaluate(V* s, const S* uniforms, const V* inputs) {
    constexpr Node n = P.nodes[I];
    if constexpr (n.op == Op::input) s[I] = inputs[n.a];
    else if constexpr (n.op == Op::constant) s[I] = V(S(n.value));
    else if constexpr (n.uniform) { if constexpr (P.slot[I] >= 0) s[I] = V(uniforms[P.slot[I]]); }
    else s[I] = apply<n.op, calls_circular<P>, V>(s[n.a], s[n.b < 0 ? n.a : n.b], s[n.c < 0 ? n.a : n.c]);
}

template <const auto& P, class V, class S, int... I, int... O>
KAGERO_INLINE void run(const S* uniforms, const V* inputs, V* outputs, std::integer_sequence<int, I...>,
                       std::integer_sequence<int, O...>) {
    V s[sizeof...(I) + 1];
    (evaluate<P, I>(s, uniforms, inputs), ...);
    ((outputs[O] = s[P.outputs[O]]), ...);
}

}  // namespace detail

/// Evaluates program P: inputs → outputs, with the uniforms that `fill_uniforms` made.
template <const auto& P, class V, class S>
KAGERO_INLINE void run(const S* uniforms, const V* inputs, V* outputs) {
    detail::run<P>(uniforms, inputs, outputs, std::make_integer_sequence<int, P.size>{},
                   std::make_integer_sequence<int, static_cast<int>(P.outputs.size())>{});
}

inline double value_of(Op op, double a, double b) { return detail::applied(op, a, b, b); }

/// Evaluates the nodes of a program that depend on parameters alone into its table of uniforms.
template <class S>
void fill_uniforms(const Node* nodes, const int* slot, int size, const S* parameters, S* uniforms) {
    S value[Tape::capacity];
    for (int i = 0; i < size; ++i) {
        const Node& n = nodes[i];
        if (!n.uniform) continue;
        const S a = n.a >= 0 && n.op != Op::parameter ? value[n.a] : S(0), b = n.b >= 0 ? value[n.b] : S(0);
        switch (n.op) {
            case Op::constant: value[i] = S(n.value); break;
            case Op::parameter: value[i] = parameters[n.a]; break;
            default: value[i] = detail::applied(n.op, a, b, b); break;
        }
        if (slot[i] >= 0) uniforms[slot[i]] = value[i];
    }
}

extern template void fill_uniforms<double>(const Node*, const int*, int, const double*, double*);  // in module.cpp

}  // namespace kagero
