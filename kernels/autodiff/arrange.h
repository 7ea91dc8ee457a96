/// Extraction of the straight-line program that computes given nodes of a tape, at compile time.
///
/// `extract` removes the nodes that the outputs do not need, rewrites products so that they share factors, orders the
/// factors of products, replaces products and sums by fused operations, and renumbers the remaining nodes.
#pragma once

#include "kernels/autodiff/tape.h"

#include <algorithm>
#include <array>

namespace kagero {

/// A straight-line program with at most `Size` nodes. The values of its uniform nodes are in a table of uniforms, which
/// `fill_uniforms` (program.h) writes once per job.
template <int Size, int Outputs>
struct Program {
    Node nodes[Size]{};  ///< In order of evaluation; operands are indices into this array.
    int slot[Size]{};    ///< Index of each uniform node in the table of uniforms; −1 for constants and other nodes.
    std::array<int, Outputs> outputs{};  ///< Indices of the output nodes.
    int size = 0;                        ///< Number of nodes.
    int uniforms = 0;                    ///< Number of entries in the table of uniforms.
    bool complete = true;                ///< False if nodes are missing because a tape was full during extraction.
    /// Returns true if the program uses an input whose index is in [first, last).
    constexpr bool uses_any_input(int first, int last) const {
        for (int k = 0; k < size; ++k)
            if (nodes[k].op == Op::input && nodes[k].a >= first && nodes[k].a < last) return true;
        return false;
    }
    /// Returns true if sin and cos are function calls in the compiled program, and false if they are inlined. Calls are
    /// used if more than 4 sin and cos nodes are not uniform.
    constexpr bool calls_sin_cos() const {
        int count = 0;
        for (int k = 0; k < size; ++k) count += !nodes[k].uniform && (nodes[k].op == Op::sin || nodes[k].op == Op::cos);
        return count > 4;
    }
    /// Returns a measure of code size: the number of nodes, plus 40 for each node that is not uniform and whose
    /// operation has the flag `is_library` (operation_table.h).
    constexpr int length() const {
        int sum = size;
        for (int k = 0; k < size; ++k) sum += !nodes[k].uniform && info_of(nodes[k].op).is_library ? 40 : 0;
        return sum;
    }
    /// Returns the greatest index of a parameter that the program uses, plus 1; 0 if it uses none.
    constexpr int parameter_count() const {
        int count = 0;
        for (int k = 0; k < size; ++k)
            if (nodes[k].op == Op::parameter && nodes[k].a >= count) count = nodes[k].a + 1;
        return count;
    }
    /// Returns true if output k is the constant 0.
    constexpr bool returns_zero(int k) const {
        const Node& n = nodes[outputs[k]];
        return n.op == Op::constant && n.value == 0;
    }
    /// Returns true if output k is input i.
    constexpr bool returns_input(int k, int i) const {
        const Node& n = nodes[outputs[k]];
        return n.op == Op::input && n.a == i;
    }
};

/// The range [first, last) of the indices of inputs that vary between consecutive evaluations of a program. The other
/// inputs stay the same. By default, all inputs vary.
struct VaryingInputs {
    int first = 0, last = 1 << 30;
};

namespace detail {

/// Returns the node n with its operands renumbered: operand i becomes new_index[i].
constexpr Node renumbered(Node n, const int* new_index) {
    if (is_leaf(n.op)) return n;
    n.a = new_index[n.a];
    if (n.b >= 0) n.b = new_index[n.b];
    if (n.c >= 0) n.c = new_index[n.c];
    return n;
}

/// For each node of a tape, the number of nodes and outputs that use it. Uses by nodes that no output needs are not
/// counted.
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

/// Rewrites products with a uniform factor u so that several of them share the product u d: u (d x) and u (d y) become
/// (u d) x and (u d) y. Returns the new tape and replaces the indices in `outputs` by those of the new tape.
template <int Outputs>
constexpr Tape share_scaled_factors(const Tape& t, std::array<int, Outputs>& outputs) {
    const Uses uses(t, outputs);
    // Returns true if node i is u·(d·x) with a uniform u, and d·x has no other use.
    const auto is_scaled_product = [&](int i) {
        const Node& n = t.nodes[i];
        return uses.count[i] > 0 && n.op == Op::mul && !n.uniform && t.uniform(n.a) && t.nodes[n.b].op == Op::mul &&
               uses.count[n.b] == 1;
    };
    int products[Tape::capacity]{};
    int count = 0;
    for (int i = 0; i < t.size; ++i)
        if (is_scaled_product(i)) products[count++] = i;
    // Returns the number of products that would share u·d.
    const auto count_sharing = [&](int u, int d) {
        int sharing = 0;
        for (int k = 0; k < count; ++k) {
            const Node& n = t.nodes[products[k]];
            if (n.a == u && (t.nodes[n.b].a == d || t.nodes[n.b].b == d)) ++sharing;
        }
        return sharing;
    };
    Tape shared;
    int new_index[Tape::capacity]{};
    for (int i = 0; i < t.size; ++i) {
        const Node& n = t.nodes[i];
        if (uses.count[i] == 0 && n.op != Op::input) continue;
        if (is_scaled_product(i)) {
            const Node& product = t.nodes[n.b];
            const int sharing_a = count_sharing(n.a, product.a), sharing_b = count_sharing(n.a, product.b);
            if (sharing_a > 1 || sharing_b > 1) {
                const int d = sharing_a >= sharing_b ? product.a : product.b;
                const int x = sharing_a >= sharing_b ? product.b : product.a;
                const int factor = shared.append({Op::mul, new_index[n.a], new_index[d], -1, 0, false});
                new_index[i] = shared.append({Op::mul, factor, new_index[x], -1, 0, false});
                continue;
            }
        }
        new_index[i] = shared.append(renumbered(n, new_index));
    }
    for (int& o : outputs) o = new_index[o];
    return shared;
}

/// Reorders the factors of products. Factors that do not depend on the varying inputs come first, so that their product
/// is computed once for many calls. The other factors are sorted by the length of their dependency chains, so that the
/// chain of the product is short. Returns the new tape and replaces the indices in `outputs`.
template <int Outputs>
constexpr Tape order_products(const Tape& t, std::array<int, Outputs>& outputs, VaryingInputs varying) {
    const Uses uses(t, outputs);
    // For each node, the length of the longest dependency chain from a varying input; −1 if there is none. Reciprocals
    // and reciprocal square roots count as 6 operations, all others as 1.
    int depth[Tape::capacity]{};
    // True for a product that depends on varying inputs and whose only use is as a factor of another product.
    bool is_inner[Tape::capacity]{};
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
            is_inner[operand] =
                is_inner[operand] ||
                (t.nodes[operand].op == Op::mul && uses.count[operand] == 1 && depth[operand] >= 0);
    }
    Tape ordered;
    int new_index[Tape::capacity]{}, factors[Tape::capacity]{};
    for (int i = 0; i < t.size; ++i) {
        const Node& n = t.nodes[i];
        if ((uses.count[i] == 0 && n.op != Op::input) || is_inner[i]) continue;
        if (n.op == Op::mul && depth[i] >= 0) {
            int count = 0;
            const auto gather_factors = [&](auto&& self, int k) -> void {
                if (is_inner[k]) {
                    self(self, t.nodes[k].a);
                    self(self, t.nodes[k].b);
                } else {
                    factors[count++] = k;
                }
            };
            gather_factors(gather_factors, n.a);
            gather_factors(gather_factors, n.b);
            const auto precedes = [&](int a, int b) {
                return t.uniform(a) != t.uniform(b) ? t.uniform(a) : depth[a] != depth[b] ? depth[a] < depth[b] : a < b;
            };
            std::sort(factors, factors + count, precedes);
            int product = new_index[factors[0]];
            for (int f = 1; f < count; ++f) {
                const int factor = new_index[factors[f]];
                product = ordered.append(
                    {Op::mul, product, factor, -1, 0, ordered.uniform(product) && ordered.uniform(factor)});
            }
            new_index[i] = product;
            continue;
        }
        new_index[i] = ordered.append(renumbered(n, new_index));
    }
    for (int& o : outputs) o = new_index[o];
    return ordered;
}

/// Replaces a·b + c, a·b − c and c − a·b by fused operations, unless the product is uniform or has another use.
constexpr void fuse(Tape& t, const Uses& uses) {
    for (int i = 0; i < t.size; ++i) {
        Node& n = t.nodes[i];
        if (n.uniform || uses.count[i] == 0 || (n.op != Op::add && n.op != Op::sub)) continue;
        // Returns true if node k is a product without another use.
        const auto is_single_use_product = [&](int k) {
            return t.nodes[k].op == Op::mul && !t.uniform(k) && uses.count[k] == 1;
        };
        if (is_single_use_product(n.b)) {
            const Node product = t.nodes[n.b];
            n = {n.op == Op::add ? Op::fma : Op::fnma, product.a, product.b, n.a, 0, false};
        } else if (is_single_use_product(n.a)) {
            const Node product = t.nodes[n.a];
            n = {n.op == Op::add ? Op::fma : Op::fms, product.a, product.b, n.b, 0, false};
        }
    }
}

/// Returns the program that computes the nodes `outputs`. Its arrays have `Tape::capacity` elements, more than needed.
template <int Outputs>
constexpr Program<Tape::capacity, Outputs> extract_untrimmed(const Tape& recorded, std::array<int, Outputs> outputs,
                                                             VaryingInputs varying = {}) {
    Tape t = share_scaled_factors<Outputs>(recorded, outputs);
    const bool sharing_complete = !t.full;
    t = order_products<Outputs>(t, outputs, varying);
    fuse(t, Uses(t, outputs));
    const Uses uses(t, outputs);
    Program<Tape::capacity, Outputs> p;
    p.complete = sharing_complete && !t.full;
    int new_index[Tape::capacity]{};
    for (int i = 0; i < t.size; ++i) {
        if (uses.count[i] == 0) continue;
        const Node n = renumbered(t.nodes[i], new_index);
        new_index[i] = p.size;
        p.slot[p.size] = n.uniform && n.op != Op::constant ? p.uniforms++ : -1;
        p.nodes[p.size++] = n;
    }
    for (int k = 0; k < Outputs; ++k) p.outputs[k] = new_index[outputs[k]];
    return p;
}

}  // namespace detail

/// Returns the program that computes the nodes `outputs` of `recording.tape`, with arrays of the required size. If a
/// loop evaluates the program and changes only the `varying` inputs, the compiler can move the operations that do not
/// depend on these inputs out of the loop.
template <const auto& recording, auto outputs, VaryingInputs varying = VaryingInputs{}>
consteval auto extract() {
    constexpr auto untrimmed =
        detail::extract_untrimmed<static_cast<int>(outputs.size())>(recording.tape, outputs, varying);
    Program<untrimmed.size, static_cast<int>(outputs.size())> p;
    for (int i = 0; i < untrimmed.size; ++i) {
        p.nodes[i] = untrimmed.nodes[i];
        p.slot[i] = untrimmed.slot[i];
    }
    p.outputs = untrimmed.outputs;
    p.size = untrimmed.size;
    p.uniforms = untrimmed.uniforms;
    p.complete = untrimmed.complete;
    return p;
}

}  // namespace kagero
