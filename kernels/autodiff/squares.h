/// Recognition of perfect squares in expanded sums, such as (a + b)² in a² + b² + 2ab.
///
/// Metrics are often printed as sums of many terms. A tape records these terms as they are written; their derivatives
/// cost about twice as much as the derivative of the square.
#pragma once

#include "kernels/autodiff/tape.h"

#include <algorithm>

namespace kagero {
namespace detail {

/// A sum on a tape in expanded form. Each term is a coefficient times powers of bases. A base is a node: a leaf, a
/// function, or a sum that is not expanded.
class ExpandedSum {
public:
    constexpr explicit ExpandedSum(Tape& t) : t_(t) {
        for (int i = 0; i < t.size; ++i)
            if (t.nodes[i].op == Op::rsqrt) has_rsqrt_[t.nodes[i].a] = true;
    }

    /// Records the sum at node `sum` with its perfect squares factored, and returns the new node. Returns `sum` if it
    /// has no perfect square, or if its expanded form exceeds `max_bases`, `max_terms`, `max_power` or `max_depth`.
    constexpr int with_squares(int sum) {
        terms_ = expand(sum);
        collect();
        find_squares();
        if (failed_ || squares_ == 0) return sum;
        Terms unsquared;
        for (int i = 0; i < terms_.count; ++i)
            if (square_of_[i] < 0) append(unsquared, terms_.term[i]);
        int total = record_sum(unsquared);
        for (int s = 0; s < squares_; ++s) total = t_.add(total, record_square(s));
        return total;
    }

private:
    static constexpr int max_bases = 24, max_terms = 48, max_squares = 4;
    static constexpr int max_power = 126 /* in units of ½ */, max_depth = 200 /* of nested operations */;

    /// A selection of bases: all, those that are inputs of the tape, or those that are not.
    enum class Bases { all, inputs, not_inputs };
    struct Term {
        double coefficient = 0;
        signed char power[max_bases]{};  ///< Exponent of each base, in units of ½.
    };
    /// A sum of terms.
    struct Terms {
        Term term[max_terms]{};
        int count = 0;
    };

    constexpr bool is_sum(int i) const { return t_.nodes[i].op == Op::add || t_.nodes[i].op == Op::sub; }
    constexpr bool is_input(int b) const { return t_.nodes[bases_[b]].op == Op::input; }
    constexpr bool has_rsqrt(int b) const { return has_rsqrt_[bases_[b]]; }

    /// Appends a term, or sets `failed_` if there is no space.
    constexpr void append(Terms& to, const Term& term) {
        if (to.count == max_terms) failed_ = true;
        else to.term[to.count++] = term;
    }
    /// Returns the sum of the single term node^(halves/2), and adds the node to the bases.
    constexpr Terms power_of(int node, int halves) {
        int b = 0;
        while (b < bases_count_ && bases_[b] != node) ++b;
        if (b == max_bases) return failed_ = true, Terms{};
        if (b == bases_count_) bases_[bases_count_++] = node;
        Terms power;
        power.count = 1;
        power.term[0].coefficient = 1;
        power.term[0].power[b] = static_cast<signed char>(halves);
        return power;
    }
    /// Returns the product of two sums of terms, without collecting equal terms.
    constexpr Terms product(const Terms& a, const Terms& b) {
        Terms products;
        for (int i = 0; i < a.count; ++i)
            for (int j = 0; j < b.count; ++j) {
                Term term = a.term[i];
                term.coefficient *= b.term[j].coefficient;
                for (int k = 0; k < bases_count_; ++k) {
                    const int power = term.power[k] + b.term[j].power[k];
                    failed_ = failed_ || power > max_power || power < -max_power;
                    term.power[k] = static_cast<signed char>(power);
                }
                append(products, term);
            }
        return products;
    }
    /// Returns the expanded form of node i. Sets `failed_` if the recursion is deeper than `max_depth`.
    constexpr Terms expand(int i) {
        if (failed_ = failed_ || depth_ >= max_depth; failed_) return Terms{};
        ++depth_;
        const Terms terms = expand_operation(i);
        --depth_;
        return terms;
    }
    /// Returns the expanded form of node i. Calls `expand` for its operands.
    constexpr Terms expand_operation(int i) {
        const Node n = t_.nodes[i];
        if (n.op == Op::constant) {
            Terms constant;
            constant.count = 1;
            constant.term[0].coefficient = n.value;
            return constant;
        }
        if (n.op == Op::neg) {
            Terms terms = expand(n.a);
            for (int k = 0; k < terms.count; ++k) terms.term[k].coefficient = -terms.term[k].coefficient;
            return terms;
        }
        if (is_sum(i) && !n.uniform && !has_rsqrt_[i]) {
            Terms terms = expand(n.a);
            const Terms second = expand(n.b);
            for (int k = 0; k < second.count; ++k) {
                append(terms, second.term[k]);
                if (n.op == Op::sub && !failed_) terms.term[terms.count - 1].coefficient = -second.term[k].coefficient;
            }
            return terms;
        }
        if (const int rsqrt = t_.reciprocal_root_of(i); rsqrt >= 0) return power_of(t_.nodes[rsqrt].a, 1);
        if (n.op == Op::rsqrt) return power_of(n.a, -1);
        if (n.op == Op::mul) return n.a == n.b && is_sum(n.a) ? power_of(n.a, 4) : product(expand(n.a), expand(n.b));
        if (n.op == Op::recip) {
            Terms reciprocal = is_sum(n.a) ? power_of(n.a, 2) : expand(n.a);
            if (reciprocal.count != 1) reciprocal = power_of(n.a, 2);
            reciprocal.term[0].coefficient = 1 / reciprocal.term[0].coefficient;
            for (signed char& power : reciprocal.term[0].power) power = static_cast<signed char>(-power);
            return reciprocal;
        }
        return power_of(i, 2);
    }

    static constexpr bool same_powers(const Term& a, const Term& b) {
        return std::equal(a.power, a.power + max_bases, b.power);
    }
    /// Combines the terms of `terms_` that have the same powers: adds their coefficients.
    constexpr void collect() {
        Terms collected;
        for (int i = 0; i < terms_.count; ++i) {
            int same = 0;
            while (same < collected.count && !same_powers(collected.term[same], terms_.term[i])) ++same;
            if (same == collected.count) append(collected, terms_.term[i]);
            else collected.term[same].coefficient += terms_.term[i].coefficient;
        }
        terms_ = collected;
    }

    /// Returns true if two terms may be a² and b² times a common factor: their coefficients are equal, and their
    /// quotient is a perfect square. If the quotient has an odd power of a base, the tape must contain 1/√base.
    constexpr bool could_be_squares(const Term& a, const Term& b) const {
        if (a.coefficient != b.coefficient) return false;
        for (int k = 0; k < bases_count_; ++k)
            if ((a.power[k] - b.power[k]) % (has_rsqrt(k) ? 2 : 4) != 0) return false;
        return true;
    }
    /// Returns the index of the term ±2ab if that term exists and is in no square yet; else −1. `a` and `b` are the
    /// terms a² and b².
    constexpr int cross_term_of(const Term& a, const Term& b) const {
        for (int x = 0; x < terms_.count; ++x) {
            const Term& term = terms_.term[x];
            bool matches =
                square_of_[x] < 0 && (term.coefficient == 2 * a.coefficient || term.coefficient == -2 * a.coefficient);
            for (int k = 0; matches && k < bases_count_; ++k)
                matches = 2 * term.power[k] == a.power[k] + b.power[k];
            if (matches) return x;
        }
        return -1;
    }
    /// Assigns terms to perfect squares. The square that is being assembled, called the current square, has the index
    /// `squares_`.
    constexpr void find_squares() {
        for (int i = 0; i < max_terms; ++i) {
            square_of_[i] = -1;
            is_squared_[i] = false;
            sign_[i] = 1;
        }
        for (int i = 0; i < terms_.count && squares_ < max_squares; ++i) {
            if (square_of_[i] >= 0) continue;
            int squared_terms = 1;
            for (int j = 0; j < terms_.count; ++j)
                if (j != i && square_of_[j] < 0 && belongs_to_square(i, j)) {
                    add_to_square(i, j);
                    ++squared_terms;
                }
            if (squared_terms > 1) {
                square_of_[i] = squares_++;
                is_squared_[i] = true;
            }
        }
    }
    /// Returns true if term j has cross terms of consistent sign with all squared terms of the current square. Term i
    /// is the first squared term of this square. Sets the sign of term j.
    constexpr bool belongs_to_square(int i, int j) {
        if (!could_be_squares(terms_.term[i], terms_.term[j])) return false;
        const int cross_term = cross_term_of(terms_.term[i], terms_.term[j]);
        if (cross_term < 0) return false;
        const int sign = terms_.term[cross_term].coefficient == 2 * terms_.term[i].coefficient ? 1 : -1;
        for (int m = 0; m < terms_.count; ++m) {
            if (square_of_[m] != squares_ || !is_squared_[m]) continue;
            const int x = cross_term_of(terms_.term[m], terms_.term[j]);
            if (x < 0 || terms_.term[x].coefficient != 2 * sign_[m] * sign * terms_.term[i].coefficient) return false;
        }
        sign_[j] = sign;
        return true;
    }
    /// Adds term j and its cross terms to the current square, whose first squared term is i.
    constexpr void add_to_square(int i, int j) {
        for (int m = 0; m < terms_.count; ++m)
            if ((square_of_[m] == squares_ && is_squared_[m]) || m == i)
                square_of_[cross_term_of(terms_.term[m], terms_.term[j])] = squares_;
        square_of_[j] = squares_;
        is_squared_[j] = true;
    }

    /// Records the square with the given index as c·g·(Σ ± s)², and returns its node. Its squared terms are c·g·s²,
    /// with a common coefficient c and a common factor g.
    constexpr int record_square(int index) {
        Terms roots;
        Term common;
        for (int i = 0; i < terms_.count; ++i) {
            if (square_of_[i] != index || !is_squared_[i]) continue;
            const Term& term = terms_.term[i];
            if (roots.count == 0) common = term;
            for (int k = 0; k < bases_count_; ++k)
                common.power[k] = common_power(common.power[k], term.power[k], has_rsqrt(k) ? 2 : 4);
            append(roots, term);
            roots.term[roots.count - 1].coefficient = sign_[i];
        }
        for (int i = 0; i < roots.count; ++i)
            for (int k = 0; k < bases_count_; ++k)
                roots.term[i].power[k] = static_cast<signed char>((roots.term[i].power[k] - common.power[k]) / 2);
        const int sum = record_sum(roots);
        return t_.mul(times(t_.constant(common.coefficient), common, Bases::all), t_.mul(sum, sum));
    }
    /// Returns the power of a base in the common factor of two terms. a and b are its powers in the two terms; they are
    /// equal modulo `modulus`. The result is the power nearer to 0, or a mod `modulus` if a and b have different signs.
    static constexpr signed char common_power(int a, int b, int modulus) {
        if (a >= 0 && b >= 0) return static_cast<signed char>(a < b ? a : b);
        if (a <= 0 && b <= 0) return static_cast<signed char>(a > b ? a : b);
        return static_cast<signed char>(a % modulus);
    }

    /// Records a sum of terms and returns its node. Terms that differ only in sign and in the powers of inputs share
    /// the product of the other bases.
    constexpr int record_sum(const Terms& terms) {
        bool is_recorded[max_terms]{};
        int total = t_.constant(0);
        for (int i = 0; i < terms.count; ++i) {
            if (is_recorded[i]) continue;
            const Term& leading = terms.term[i];
            int sum_of_inputs = t_.constant(0);
            for (int j = i; j < terms.count; ++j) {
                const Term& term = terms.term[j];
                if (is_recorded[j] ||
                    (term.coefficient != leading.coefficient && term.coefficient != -leading.coefficient))
                    continue;
                bool has_same_factor = true;
                for (int k = 0; k < bases_count_; ++k)
                    has_same_factor = has_same_factor && (is_input(k) || term.power[k] == leading.power[k]);
                if (!has_same_factor) continue;
                const int product = times(t_.constant(1), term, Bases::inputs);
                sum_of_inputs = term.coefficient == leading.coefficient ? t_.add(sum_of_inputs, product)
                                                                        : t_.sub(sum_of_inputs, product);
                is_recorded[j] = true;
            }
            const int factor = times(t_.constant(leading.coefficient), leading, Bases::not_inputs);
            total = t_.add(total, t_.mul(factor, sum_of_inputs));
        }
        return total;
    }
    /// Records the product of `node` and the term's powers of the selected bases. Returns the node of the product.
    constexpr int times(int node, const Term& term, Bases bases) {
        for (int b = 0; b < bases_count_; ++b) {
            if (bases != Bases::all && is_input(b) != (bases == Bases::inputs)) continue;
            int halves = term.power[b];
            for (; halves >= 2; halves -= 2) node = t_.mul(node, bases_[b]);
            if (halves == 1) node = t_.mul(node, t_.sqrt(bases_[b]));
            for (; halves < 0 && has_rsqrt(b); ++halves) node = t_.mul(node, t_.unary(Op::rsqrt, bases_[b]));
            for (; halves < 0; halves += 2) node = t_.mul(node, t_.recip(bases_[b]));
        }
        return node;
    }

    Tape& t_;
    bool has_rsqrt_[Tape::capacity]{};  ///< True for each node s for which the tape contains 1/√s.
    int bases_[max_bases]{};            ///< Nodes of the bases.
    int bases_count_ = 0;
    Terms terms_{};                 ///< The expanded form of the sum.
    bool failed_ = false;           ///< True if a limit was exceeded.
    int depth_ = 0;                 ///< Recursion depth of `expand`.
    int square_of_[max_terms]{};    ///< For each term, the index of the square that contains it, or −1.
    bool is_squared_[max_terms]{};  ///< For each term, true if it is a squared term a², not a cross term 2ab.
    int sign_[max_terms]{};         ///< For each squared term a², the sign of a in the sum that is squared.
    int squares_ = 0;               ///< Number of squares.
};

/// Returns the number of operations that are needed to compute a node. Uniform nodes are not counted.
constexpr int operations_to(const Tape& t, int node) {
    bool needed[Tape::capacity]{};
    needed[node] = true;
    int count = 0;
    for (int i = node; i >= 0; --i) {
        const Node& n = t.nodes[i];
        if (!needed[i] || n.uniform || n.op == Op::input) continue;
        ++count;
        needed[n.a] = true;
        if (n.b >= 0) needed[n.b] = true;
    }
    return count;
}

}  // namespace detail

/// Rewrites the sum at node `sum` as a sum of perfect squares and remaining terms, if this saves operations. Returns
/// the node of the sum.
constexpr int collect_squares(Tape& t, int sum) {
    Tape candidate = t;
    const int factored = detail::ExpandedSum(candidate).with_squares(sum);
    if (candidate.full || detail::operations_to(candidate, factored) >= detail::operations_to(t, sum)) return sum;
    t = candidate;
    return factored;
}

}  // namespace kagero
