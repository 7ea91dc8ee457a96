/// Recognition of perfect squares in expanded sums, such as (a + b)² in a² + b² + 2ab.
///
/// Metrics are often printed term by term. A tape records the terms as they are written; their derivatives cost about
/// twice as much as the derivative of the square.
#pragma once

#include "kernels/autodiff/tape.h"

#include <algorithm>

namespace kagero {
namespace detail {

/// A sum on a tape in expanded form. Each term is a coefficient times powers of bases. Bases are leaves, functions, and
/// sums that are not expanded.
class ExpandedSum {
public:
    constexpr explicit ExpandedSum(Tape& t) : t_(t) {
        for (int i = 0; i < t.size; ++i)
            if (t.nodes[i].op == Op::rsqrt) has_root_[t.nodes[i].a] = true;
    }

    /// Records the sum at node `sum` with its perfect squares factored, and returns the new node. Returns `sum` if it
    /// has no perfect square, or if its expanded form exceeds the limits below.
    constexpr int with_squares(int sum) {
        terms_ = expand(sum);
        collect();
        find_squares();
        if (failed_ || squares_ == 0) return sum;
        Terms rest;
        for (int i = 0; i < terms_.count; ++i)
            if (group_[i] < 0) append(rest, terms_.term[i]);
        int total = sum_of(rest);
        for (int g = 0; g < squares_; ++g) total = t_.add(total, square(g));
        return total;
    }

private:
    static constexpr int max_bases = 24, max_terms = 48, max_squares = 4;
    static constexpr int max_power = 126 /* in units of ½ */, max_depth = 200 /* of nested operations */;

    enum class Bases { all, inputs, others };
    struct Term {
        double coefficient = 0;
        signed char power[max_bases]{};  ///< Exponent of each base, in units of ½.
    };
    struct Terms {
        Term term[max_terms]{};
        int count = 0;
    };

    constexpr bool is_sum(int i) const { return t_.nodes[i].op == Op::add || t_.nodes[i].op == Op::sub; }
    constexpr bool is_input(int b) const { return t_.nodes[bases_[b]].op == Op::input; }
    constexpr bool has_root(int b) const { return has_root_[bases_[b]]; }

    constexpr void append(Terms& to, const Term& term) {
        if (to.count == max_terms) failed_ = true;
        else to.term[to.count++] = term;
    }
    /// Returns the term node^(halves/2).
    constexpr Terms base(int node, int halves) {
        int b = 0;
        while (b < bases_count_ && bases_[b] != node) ++b;
        if (b == max_bases) return failed_ = true, Terms{};
        if (b == bases_count_) bases_[bases_count_++] = node;
        Terms one;
        one.count = 1;
        one.term[0].coefficient = 1;
        one.term[0].power[b] = static_cast<signed char>(halves);
        return one;
    }
    /// Returns the product of two sums of terms, without collecting equal terms.
    constexpr Terms product(const Terms& a, const Terms& b) {
        Terms all;
        for (int i = 0; i < a.count; ++i)
            for (int j = 0; j < b.count; ++j) {
                Term term = a.term[i];
                term.coefficient *= b.term[j].coefficient;
                for (int k = 0; k < bases_count_; ++k) {
                    const int power = term.power[k] + b.term[j].power[k];
                    failed_ = failed_ || power > max_power || power < -max_power;
                    term.power[k] = static_cast<signed char>(power);
                }
                append(all, term);
            }
        return all;
    }
    /// Returns the expanded form of node i, and limits the depth of the recursion.
    constexpr Terms expand(int i) {
        if (failed_ = failed_ || depth_ >= max_depth; failed_) return Terms{};
        ++depth_;
        const Terms all = expanded(i);
        --depth_;
        return all;
    }
    /// Returns the expanded form of node i. Calls `expand` for its operands.
    constexpr Terms expanded(int i) {
        const Node n = t_.nodes[i];
        if (n.op == Op::constant) {
            Terms one;
            one.count = 1;
            one.term[0].coefficient = n.value;
            return one;
        }
        if (n.op == Op::neg) {
            Terms all = expand(n.a);
            for (int k = 0; k < all.count; ++k) all.term[k].coefficient = -all.term[k].coefficient;
            return all;
        }
        if (is_sum(i) && !n.uniform && !has_root_[i]) {
            Terms all = expand(n.a);
            const Terms more = expand(n.b);
            for (int k = 0; k < more.count; ++k) {
                append(all, more.term[k]);
                if (n.op == Op::sub && !failed_) all.term[all.count - 1].coefficient = -more.term[k].coefficient;
            }
            return all;
        }
        if (const int root = t_.reciprocal_root_of(i); root >= 0) return base(t_.nodes[root].a, 1);
        if (n.op == Op::rsqrt) return base(n.a, -1);
        if (n.op == Op::mul) return n.a == n.b && is_sum(n.a) ? base(n.a, 4) : product(expand(n.a), expand(n.b));
        if (n.op == Op::recip) {
            Terms one = is_sum(n.a) ? base(n.a, 2) : expand(n.a);
            if (one.count != 1) one = base(n.a, 2);
            one.term[0].coefficient = 1 / one.term[0].coefficient;
            for (signed char& power : one.term[0].power) power = static_cast<signed char>(-power);
            return one;
        }
        return base(i, 2);
    }

    static constexpr bool same_bases(const Term& a, const Term& b) {
        return std::equal(a.power, a.power + max_bases, b.power);
    }
    /// Adds the coefficients of terms with the same powers.
    constexpr void collect() {
        Terms all;
        for (int i = 0; i < terms_.count; ++i) {
            int same = 0;
            while (same < all.count && !same_bases(all.term[same], terms_.term[i])) ++same;
            if (same == all.count) append(all, terms_.term[i]);
            else all.term[same].coefficient += terms_.term[i].coefficient;
        }
        terms_ = all;
    }

    /// Returns true if the terms may be a² and b² times a common factor: their quotient is a perfect square. An odd
    /// exponent in the quotient is allowed only if the tape contains the square root of the base.
    constexpr bool could_be_squares(const Term& a, const Term& b) const {
        if (a.coefficient != b.coefficient) return false;
        for (int k = 0; k < bases_count_; ++k)
            if ((a.power[k] - b.power[k]) % (has_root(k) ? 2 : 4) != 0) return false;
        return true;
    }
    /// Returns the index of the term ±2ab for the terms a² and b², if it is in no square yet; else −1.
    constexpr int cross_term_of(const Term& a, const Term& b) const {
        for (int x = 0; x < terms_.count; ++x) {
            const Term& term = terms_.term[x];
            bool matches =
                group_[x] < 0 && (term.coefficient == 2 * a.coefficient || term.coefficient == -2 * a.coefficient);
            for (int k = 0; matches && k < bases_count_; ++k)
                matches = 2 * term.power[k] == a.power[k] + b.power[k];
            if (matches) return x;
        }
        return -1;
    }
    /// Assigns terms to perfect squares.
    constexpr void find_squares() {
        for (int i = 0; i < max_terms; ++i) {
            group_[i] = -1;
            is_squared_[i] = false;
            sign_[i] = 1;
        }
        for (int i = 0; i < terms_.count && squares_ < max_squares; ++i) {
            if (group_[i] >= 0) continue;
            int members = 1;
            for (int j = 0; j < terms_.count; ++j)
                if (j != i && group_[j] < 0 && belongs_to_square(i, j)) {
                    add_to_square(i, j);
                    ++members;
                }
            if (members > 1) {
                group_[i] = squares_++;
                is_squared_[i] = true;
            }
        }
    }
    /// Returns true if term j has cross terms of consistent sign with all squared terms of the current square, whose
    /// first squared term is i. Sets the sign of term j.
    constexpr bool belongs_to_square(int i, int j) {
        if (!could_be_squares(terms_.term[i], terms_.term[j])) return false;
        const int first = cross_term_of(terms_.term[i], terms_.term[j]);
        if (first < 0) return false;
        const int sign = terms_.term[first].coefficient == 2 * terms_.term[i].coefficient ? 1 : -1;
        for (int m = 0; m < terms_.count; ++m) {
            if (group_[m] != squares_ || !is_squared_[m]) continue;
            const int x = cross_term_of(terms_.term[m], terms_.term[j]);
            if (x < 0 || terms_.term[x].coefficient != 2 * sign_[m] * sign * terms_.term[i].coefficient) return false;
        }
        sign_[j] = sign;
        return true;
    }
    /// Adds term j and its cross terms to the current square.
    constexpr void add_to_square(int i, int j) {
        for (int m = 0; m < terms_.count; ++m)
            if ((group_[m] == squares_ && is_squared_[m]) || m == i)
                group_[cross_term_of(terms_.term[m], terms_.term[j])] = squares_;
        group_[j] = squares_;
        is_squared_[j] = true;
    }

    /// Records c·g·(Σ ± s)² and returns its node. The squared terms are c·g·s² with a common coefficient c and a common
    /// factor g.
    constexpr int square(int group) {
        Terms roots;
        Term common;
        for (int i = 0; i < terms_.count; ++i) {
            if (group_[i] != group || !is_squared_[i]) continue;
            const Term& term = terms_.term[i];
            if (roots.count == 0) common = term;
            for (int k = 0; k < bases_count_; ++k)
                common.power[k] = common_power(common.power[k], term.power[k], has_root(k) ? 2 : 4);
            append(roots, term);
            roots.term[roots.count - 1].coefficient = sign_[i];
        }
        for (int i = 0; i < roots.count; ++i)
            for (int k = 0; k < bases_count_; ++k)
                roots.term[i].power[k] = static_cast<signed char>((roots.term[i].power[k] - common.power[k]) / 2);
        const int sum = sum_of(roots);
        return t_.mul(times(t_.constant(common.coefficient), common, Bases::all), t_.mul(sum, sum));
    }
    /// Returns the power of a base in the common factor of two terms, in which its powers are a and b. They are equal
    /// modulo `modulus`. The result is the power nearer to 0, or the remainder if the signs differ.
    static constexpr signed char common_power(int a, int b, int modulus) {
        if (a >= 0 && b >= 0) return static_cast<signed char>(a < b ? a : b);
        if (a <= 0 && b <= 0) return static_cast<signed char>(a > b ? a : b);
        return static_cast<signed char>(a % modulus);
    }

    /// Records a sum of terms. Terms that differ only in the powers of inputs share the product of the other bases.
    constexpr int sum_of(const Terms& terms) {
        bool done[max_terms]{};
        int total = t_.constant(0);
        for (int i = 0; i < terms.count; ++i) {
            if (done[i]) continue;
            const Term& first = terms.term[i];
            int inner = t_.constant(0);
            for (int j = i; j < terms.count; ++j) {
                const Term& term = terms.term[j];
                if (done[j] || (term.coefficient != first.coefficient && term.coefficient != -first.coefficient))
                    continue;
                bool alike = true;
                for (int k = 0; k < bases_count_; ++k)
                    alike = alike && (is_input(k) || term.power[k] == first.power[k]);
                if (!alike) continue;
                const int product = times(t_.constant(1), term, Bases::inputs);
                inner = term.coefficient == first.coefficient ? t_.add(inner, product) : t_.sub(inner, product);
                done[j] = true;
            }
            total = t_.add(total, t_.mul(times(t_.constant(first.coefficient), first, Bases::others), inner));
        }
        return total;
    }
    /// Records the product of `node` and the term's powers of the selected bases.
    constexpr int times(int node, const Term& term, Bases bases) {
        for (int b = 0; b < bases_count_; ++b) {
            if (bases != Bases::all && is_input(b) != (bases == Bases::inputs)) continue;
            int halves = term.power[b];
            for (; halves >= 2; halves -= 2) node = t_.mul(node, bases_[b]);
            if (halves == 1) node = t_.mul(node, t_.sqrt(bases_[b]));
            for (; halves < 0 && has_root(b); ++halves) node = t_.mul(node, t_.unary(Op::rsqrt, bases_[b]));
            for (; halves < 0; halves += 2) node = t_.mul(node, t_.recip(bases_[b]));
        }
        return node;
    }

    Tape& t_;
    bool has_root_[Tape::capacity]{};  ///< True for nodes whose square root is on the tape.
    int bases_[max_bases]{};
    int bases_count_ = 0;
    Terms terms_{};
    bool failed_ = false;
    int depth_ = 0;                 ///< Recursion depth of `expand`.
    int group_[max_terms]{};        ///< For each term, the index of the square that contains it, or −1.
    bool is_squared_[max_terms]{};  ///< For each term, true if it is a squared term a², not a cross term 2ab.
    int sign_[max_terms]{};         ///< For each squared term a², the sign of a in the sum that is squared.
    int squares_ = 0;               ///< Number of squares.
};

/// Returns the number of operations that compute node `root`. Uniform nodes are not counted.
constexpr int operations_to(const Tape& t, int root) {
    bool needed[Tape::capacity]{};
    needed[root] = true;
    int count = 0;
    for (int i = root; i >= 0; --i) {
        const Node& n = t.nodes[i];
        if (!needed[i] || n.uniform || n.op == Op::input) continue;
        ++count;
        needed[n.a] = true;
        if (n.b >= 0) needed[n.b] = true;
    }
    return count;
}

}  // namespace detail

/// Factors the perfect squares among the terms of node `sum` if this saves operations. Returns the node of the sum.
constexpr int collect_squares(Tape& t, int sum) {
    Tape candidate = t;
    const int factored = detail::ExpandedSum(candidate).with_squares(sum);
    if (candidate.full || detail::operations_to(candidate, factored) >= detail::operations_to(t, sum)) return sum;
    t = candidate;
    return factored;
}

}  // namespace kagero
