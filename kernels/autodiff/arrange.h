/// From a tape to a straight-line program, at compile time: what is left when only some of the tape's nodes are wanted.
///
/// `extract` drops what the outputs do not need, shares factors, orders products, fuses them into sums, and numbers the
/// rest.
#pragma once

#include "kernels/autodiff/tape.h"

#include <algorithm>
#include <array>

namespace kagero {

template <int Size, int Outputs>
struct Program {
    Node nodes[Size]{};  ///< in order of evaluation; operands are indices into this array
    int slot[Size]{};    ///< of a uniform node in the table of uniforms, else −1
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
        for (int k = 0; k < size; ++k) sum += !nodes[k].uniform && info_of(nodes[k].op).is_library ? 40 : 0;
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

constexpr bool is_leaf(Op op) { return op <= Op::input; }

/// A node whose operands have moved to other places.
constexpr Node moved(Node n, const int* place) {
    if (is_leaf(n.op)) return n;
    n.a = place[n.a];
    if (n.b >= 0) n.b = place[n.b];
    if (n.c >= 0) n.c = place[n.c];
    return n;
}

/// How many nodes, and outputs, take each node.
struct Uses {
    int count[Tape::capacity]{};
    template <std::size_t Outputs>
    constexpr Uses(const Tape& t, const std::array<int, Outputs>& outputs) {
        for (int o : outputs) ++count[o];
        for (int i = t.size - 1; i >= 0; --i) {
            const Node& n = t.nodes[i];
            if (count[i] == 0 || is_leaf(n.op)) continue;
            ++count[n.a];
            if (n.b >= 0) ++count[n.b];
            if (n.c >= 0) ++count[n.c];
        }
    }
};

/// Uniform factors travel inward where that lets several products share one: u (d x), u (d y) become (u d) x, (u d) y.
template <int Outputs>
constexpr Tape share_scaled(const Tape& t, std::array<int, Outputs>& outputs) {
    const Uses uses(t, outputs);
    const auto scaled_product = [&](int i) {
        const Node& n = t.nodes[i];
        return uses.count[i] > 0 && n.op == Op::mul && !n.uniform && t.uniform(n.a) && t.nodes[n.b].op == Op::mul &&
               uses.count[n.b] == 1;
    };
    int products[Tape::capacity]{};
    int count = 0;
    for (int i = 0; i < t.size; ++i)
        if (scaled_product(i)) products[count++] = i;
    /// How many products would share u·d.
    const auto shared_by = [&](int u, int d) {
        int sharing = 0;
        for (int k = 0; k < count; ++k) {
            const Node& n = t.nodes[products[k]];
            if (n.a == u && (t.nodes[n.b].a == d || t.nodes[n.b].b == d)) ++sharing;
        }
        return sharing;
    };
    Tape shared;
    int place[Tape::capacity]{};
    for (int i = 0; i < t.size; ++i) {
        const Node& n = t.nodes[i];
        if (uses.count[i] == 0 && n.op != Op::input) continue;
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

/// Reorders products: factors that stay meet first, and are multiplied once for many calls; of the others those that
/// are known earliest, so that no product waits longer than its last factor.
template <int Outputs>
constexpr Tape order_products(const Tape& t, std::array<int, Outputs>& outputs, Varying varying) {
    const Uses uses(t, outputs);
    int depth[Tape::capacity]{};  // operations on the way from the varying inputs; −1 where nothing varies
    bool inner[Tape::capacity]{}; // a product whose only use is another product
    for (int i = 0; i < t.size; ++i) {
        const Node& n = t.nodes[i];
        if (is_leaf(n.op)) {
            depth[i] = n.op == Op::input && n.a >= varying.first && n.a < varying.last ? 0 : -1;
            continue;
        }
        depth[i] = std::max({depth[n.a], n.b < 0 ? -1 : depth[n.b], n.c < 0 ? -1 : depth[n.c]});
        if (depth[i] >= 0) depth[i] += n.op == Op::rsqrt || n.op == Op::recip ? 6 : 1;
        if (uses.count[i] == 0 || n.op != Op::mul || depth[i] < 0) continue;
        for (int operand : {n.a, n.b})
            inner[operand] =
                inner[operand] || (t.nodes[operand].op == Op::mul && uses.count[operand] == 1 && depth[operand] >= 0);
    }
    Tape ordered;
    int place[Tape::capacity]{}, factors[Tape::capacity]{};
    for (int i = 0; i < t.size; ++i) {
        const Node& n = t.nodes[i];
        if ((uses.count[i] == 0 && n.op != Op::input) || inner[i]) continue;
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
            std::sort(factors, factors + count, earlier);
            int product = place[factors[0]];
            for (int f = 1; f < count; ++f) {
                const int factor = place[factors[f]];
                product = ordered.append(
                    {Op::mul, product, factor, -1, 0, ordered.uniform(product) && ordered.uniform(factor)});
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
constexpr void fuse(Tape& t, const Uses& uses) {
    for (int i = 0; i < t.size; ++i) {
        Node& n = t.nodes[i];
        if (n.uniform || uses.count[i] == 0 || (n.op != Op::add && n.op != Op::sub)) continue;
        const auto lone_product = [&](int k) {
            return t.nodes[k].op == Op::mul && !t.uniform(k) && uses.count[k] == 1;
        };
        if (lone_product(n.b)) {
            const Node product = t.nodes[n.b];
            n = {n.op == Op::add ? Op::fma : Op::fnma, product.a, product.b, n.a, 0, false};
        } else if (lone_product(n.a)) {
            const Node product = t.nodes[n.a];
            n = {n.op == Op::add ? Op::fma : Op::fms, product.a, product.b, n.b, 0, false};
        }
    }
}

template <int Outputs>
constexpr Program<Tape::capacity, Outputs> extract_all(const Tape& recorded, std::array<int, Outputs> outputs,
                                                       Varying varying = {}) {
    Tape t = share_scaled<Outputs>(recorded, outputs);
    const bool shared = !t.full;
    t = order_products<Outputs>(t, outputs, varying);
    fuse(t, Uses(t, outputs));
    const Uses uses(t, outputs);
    Program<Tape::capacity, Outputs> p;
    p.whole = shared && !t.full;
    int place[Tape::capacity]{};
    for (int i = 0; i < t.size; ++i) {
        if (uses.count[i] == 0) continue;
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

}  // namespace kagero
