/// Perfect squares among the terms of a sum, as (a + b)² written out is: a² + b² + 2ab.
///
/// Metrics are often printed term by term. A tape takes what it is given, and would differentiate every product of such
/// a sum by itself, at twice the cost of the square that they are together.
#pragma once

#include "kernels/autodiff/tape.h"

#include <algorithm>

namespace kagero {
namespace detail {

/// A sum on a tape as products of bases: leaves, functions, and sums that no product multiplies out.
class ExpandedSum {
public:
    constexpr explicit ExpandedSum(Tape& t) : t_(t) {
        for (int i = 0; i < t.size; ++i)
            if (t.nodes[i].op == Op::rsqrt) rooted_[t.nodes[i].a] = true;
    }

    /// The same number as node `sum` with perfect squares taken together; `sum` itself where it has none, or is too
    /// long to tell.
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
    static constexpr int most_bases = 24, most_terms = 48, most_squares = 4, greatest_power = 126 /* in halves */,
                         greatest_depth = 200;

    enum class Bases { all, inputs, others };
    struct Term {
        double coefficient = 0;
        signed char power[most_bases]{};  ///< of each base, in halves
    };
    struct Terms {
        Term term[most_terms]{};
        int count = 0;
    };

    constexpr bool is_sum(int i) const { return t_.nodes[i].op == Op::add || t_.nodes[i].op == Op::sub; }
    constexpr bool is_input(int b) const { return t_.nodes[bases_[b]].op == Op::input; }
    constexpr bool rooted(int b) const { return rooted_[bases_[b]]; }

    constexpr void append(Terms& to, const Term& term) {
        if (to.count == most_terms) failed_ = true;
        else to.term[to.count++] = term;
    }
    constexpr Terms base(int node, int halves) {
        int b = 0;
        while (b < bases_count_ && bases_[b] != node) ++b;
        if (b == most_bases) return failed_ = true, Terms{};
        if (b == bases_count_) bases_[bases_count_++] = node;
        Terms one;
        one.count = 1, one.term[0].coefficient = 1, one.term[0].power[b] = static_cast<signed char>(halves);
        return one;
    }
    constexpr Terms product(const Terms& a, const Terms& b) {
        Terms all;
        for (int i = 0; i < a.count; ++i)
            for (int j = 0; j < b.count; ++j) {
                Term term = a.term[i];
                term.coefficient *= b.term[j].coefficient;
                for (int k = 0; k < bases_count_; ++k) {
                    const int power = term.power[k] + b.term[j].power[k];
                    failed_ = failed_ || power > greatest_power || power < -greatest_power;
                    term.power[k] = static_cast<signed char>(power);
                }
                append(all, term);
            }
        return all;
    }
    constexpr Terms expand(int i) {
        if (failed_ = failed_ || depth_ >= greatest_depth; failed_) return Terms{};
        ++depth_;
        const Terms all = expanded(i);
        --depth_;
        return all;
    }
    constexpr Terms expanded(int i) {
        const Node n = t_.nodes[i];
        if (n.op == Op::constant) {
            Terms one;
            one.count = 1, one.term[0].coefficient = n.value;
            return one;
        }
        if (n.op == Op::neg) {
            Terms all = expand(n.a);
            for (int k = 0; k < all.count; ++k) all.term[k].coefficient = -all.term[k].coefficient;
            return all;
        }
        if (is_sum(i) && !n.uniform && !rooted_[i]) {
            Terms all = expand(n.a);
            const Terms more = expand(n.b);
            for (int k = 0; k < more.count; ++k) {
                append(all, more.term[k]);
                if (n.op == Op::sub && !failed_) all.term[all.count - 1].coefficient = -more.term[k].coefficient;
            }
            return all;
        }
        if (const int root = t_.root_of(i); root >= 0) return base(t_.nodes[root].a, 1);
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
        return std::equal(a.power, a.power + most_bases, b.power);
    }
    /// Adds up terms of the same bases.
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

    /// Whether these may be a² and b²; roots of bases are taken only where the tape has them.
    constexpr bool could_be_squares(const Term& a, const Term& b) const {
        if (a.coefficient != b.coefficient) return false;
        for (int k = 0; k < bases_count_; ++k)
            if ((a.power[k] - b.power[k]) % (rooted(k) ? 2 : 4) != 0) return false;
        return true;
    }
    /// The term ±2ab of a² and b²; −1: there is none.
    constexpr int cross_of(const Term& a, const Term& b) const {
        for (int x = 0; x < terms_.count; ++x) {
            const Term& term = terms_.term[x];
            bool is =
                group_[x] < 0 && (term.coefficient == 2 * a.coefficient || term.coefficient == -2 * a.coefficient);
            for (int k = 0; is && k < bases_count_; ++k) is = 2 * term.power[k] == a.power[k] + b.power[k];
            if (is) return x;
        }
        return -1;
    }
    constexpr void find_squares() {
        for (int i = 0; i < most_terms; ++i) group_[i] = -1, root_[i] = false, sign_[i] = 1;
        for (int i = 0; i < terms_.count && squares_ < most_squares; ++i) {
            if (group_[i] >= 0) continue;
            int members = 1;
            for (int j = 0; j < terms_.count; ++j)
                if (j != i && group_[j] < 0 && joins(i, j)) {
                    take(i, j), ++members;
                }
            if (members > 1) group_[i] = squares_++, root_[i] = true;
        }
    }
    /// Whether term j has the right cross terms with the square that begins with term i, whose other roots are known;
    /// gives it its sign.
    constexpr bool joins(int i, int j) {
        if (!could_be_squares(terms_.term[i], terms_.term[j])) return false;
        const int first = cross_of(terms_.term[i], terms_.term[j]);
        if (first < 0) return false;
        const int sign = terms_.term[first].coefficient == 2 * terms_.term[i].coefficient ? 1 : -1;
        for (int m = 0; m < terms_.count; ++m) {
            if (group_[m] != squares_ || !root_[m]) continue;
            const int x = cross_of(terms_.term[m], terms_.term[j]);
            if (x < 0 || terms_.term[x].coefficient != 2 * sign_[m] * sign * terms_.term[i].coefficient) return false;
        }
        sign_[j] = sign;
        return true;
    }
    constexpr void take(int i, int j) {
        for (int m = 0; m < terms_.count; ++m)
            if ((group_[m] == squares_ && root_[m]) || m == i)
                group_[cross_of(terms_.term[m], terms_.term[j])] = squares_;
        group_[j] = squares_, root_[j] = true;
    }

    /// c·g·(Σ ± s)², with g what the squares have in common.
    constexpr int square(int group) {
        Terms roots;
        Term common;
        for (int i = 0; i < terms_.count; ++i) {
            if (group_[i] != group || !root_[i]) continue;
            const Term& term = terms_.term[i];
            if (roots.count == 0) common = term;
            for (int k = 0; k < bases_count_; ++k)
                common.power[k] = nearer_to_none(common.power[k], term.power[k], rooted(k) ? 2 : 4);
            append(roots, term), roots.term[roots.count - 1].coefficient = sign_[i];
        }
        for (int i = 0; i < roots.count; ++i)
            for (int k = 0; k < bases_count_; ++k)
                roots.term[i].power[k] = static_cast<signed char>((roots.term[i].power[k] - common.power[k]) / 2);
        const int sum = sum_of(roots);
        return t_.mul(times(t_.constant(common.coefficient), common, Bases::all), t_.mul(sum, sum));
    }
    /// The power that two powers with the same remainder have in common; if their signs differ, the remainder.
    static constexpr signed char nearer_to_none(int a, int b, int modulus) {
        if (a >= 0 && b >= 0) return static_cast<signed char>(a < b ? a : b);
        if (a <= 0 && b <= 0) return static_cast<signed char>(a > b ? a : b);
        return static_cast<signed char>(a % modulus);
    }

    /// Terms that share all but inputs share the product of it.
    constexpr int sum_of(const Terms& terms) {
        bool done[most_terms]{};
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
    /// node · the term's powers of these bases.
    constexpr int times(int node, const Term& term, Bases bases) {
        for (int b = 0; b < bases_count_; ++b) {
            if (bases != Bases::all && is_input(b) != (bases == Bases::inputs)) continue;
            int halves = term.power[b];
            for (; halves >= 2; halves -= 2) node = t_.mul(node, bases_[b]);
            if (halves == 1) node = t_.mul(node, t_.sqrt(bases_[b]));
            for (; halves < 0 && rooted(b); ++halves) node = t_.mul(node, t_.unary(Op::rsqrt, bases_[b]));
            for (; halves < 0; halves += 2) node = t_.mul(node, t_.recip(bases_[b]));
        }
        return node;
    }

    Tape& t_;
    bool rooted_[Tape::capacity]{};  ///< nodes whose root the tape takes
    int bases_[most_bases]{};
    int bases_count_ = 0;
    Terms terms_{};
    bool failed_ = false;
    int depth_ = 0;  ///< of sums and products that are being expanded
    int group_[most_terms]{};   ///< of each term: the square that it is part of, or −1
    bool root_[most_terms]{};   ///< … as a², not as 2ab
    int sign_[most_terms]{};    ///< … of a
    int squares_ = 0;
};

/// Operations that node `root` takes, those of uniforms aside.
constexpr int operations_to(const Tape& t, int root) {
    bool needed[Tape::capacity]{};
    needed[root] = true;
    int count = 0;
    for (int i = root; i >= 0; --i) {
        const Node& n = t.nodes[i];
        if (!needed[i] || n.uniform || n.op == Op::input) continue;
        ++count, needed[n.a] = true;
        if (n.b >= 0) needed[n.b] = true;
    }
    return count;
}

}  // namespace detail

/// The same number as node `sum`, perfect squares among its terms taken together where that is shorter.
constexpr int take_squares_together(Tape& t, int sum) {
    Tape other = t;
    const int shorter = detail::ExpandedSum(other).with_squares(sum);
    if (other.full || detail::operations_to(other, shorter) >= detail::operations_to(t, sum)) return sum;
    t = other;
    return shorter;
}

}  // namespace kagero
