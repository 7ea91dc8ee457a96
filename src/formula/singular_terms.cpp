#include "formula/singular_terms.h"

#include "kernels/operation.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace kagero {
namespace {

/// Greater polynomials and powers are not expanded.
constexpr std::size_t max_terms = 200, max_products = 10'000;
constexpr int max_power = 64;

const Polynomial torque_squared{{{{atom_sin_theta, 2}, {atom_L2, 1}}, 1}, {{{atom_pphi, 2}}, -1}};
const Polynomial cosine_squared{{{}, 1}, {{{atom_sin_theta, 2}}, -1}};

Polynomial atom_polynomial(std::int32_t atom, int power = 1) { return {{atom_to(atom, power), 1}}; }

/// Returns true if the polynomial is small and its coefficients are finite.
bool is_usable(const Polynomial& p) {
    return p.size() <= max_terms && std::ranges::all_of(p, [](const auto& term) {
        const auto is_small = [](const auto& factor) { return std::abs(factor.second) <= max_power; };
        return std::isfinite(term.second) && std::ranges::all_of(term.first, is_small);
    });
}

/// Returns the product of two polynomials, or one that is not usable if it would take too long.
Polynomial bounded_product(const Polynomial& a, const Polynomial& b) {
    if (a.size() * b.size() > max_products) return {{{}, std::nan("")}};
    return product(a, b);
}

bool is_regular_term(const Monomial& monomial) {
    const int power = power_of(monomial, atom_sin_theta);
    return power >= 0 && power % 2 == 0;
}

}  // namespace

bool SingularTerms::has_textbook_variables(std::int32_t node) const {
    return (scope_.variables[static_cast<std::size_t>(node)] & FormulaScope::textbook_bit) != 0;
}

/// Returns true if an atom is a node that is a sum.
bool SingularTerms::is_sum(std::int32_t atom) const {
    return atom >= 0 && (at(atom).op == Op::add || at(atom).op == Op::sub);
}

/// Returns the first node with the same operation and operands.
std::int32_t SingularTerms::representative(std::int32_t node) {
    if (const auto known = representative_of_.find(node); known != representative_of_.end()) return known->second;
    const FormulaNode& n = at(node);
    std::array<double, 4> key{double(n.op), double(n.a), double(n.b), n.value};
    if (!is_leaf(n.op)) {
        key[1] = representative(n.a);
        if (n.b >= 0) key[2] = representative(n.b);
        if ((n.op == Op::add || n.op == Op::mul) && key[1] > key[2]) std::swap(key[1], key[2]);
    }
    return representative_of_[node] = representatives_.try_emplace(key, node).first->second;
}

bool SingularTerms::is_regular(std::int32_t node) {
    if (!has_textbook_variables(node)) return true;
    if (const auto known = regular_.find(node); known != regular_.end()) return known->second;
    const bool regular = find_regular(node);
    return regular_[node] = regular;
}

/// Returns is_regular(node) for a node with textbook variables.
bool SingularTerms::find_regular(std::int32_t node) {
    const FormulaNode& n = at(node);
    if (n.op == Op::input)
        return !is(n, Textbook::theta) && !is(n, Textbook::phi) && !is(n, Textbook::rho) && !is(n, Textbook::ptheta) &&
               !is(n, Textbook::prho);
    const FormulaNode& operand = at(n.a);
    const bool of_theta = is(operand, Textbook::theta), is_sine = n.op == Op::sin && of_theta;
    if (is_sine || (n.op == Op::tan && of_theta)) return false;
    if (n.op == Op::cos && of_theta) return true;
    if (n.op == Op::mul && equal(n.a, n.b) &&
        (is(operand, Textbook::rho) || (operand.op == Op::sin && is(at(operand.a), Textbook::theta))))
        return true;
    if (n.op == Op::div && vanishes(n.b)) return false;
    return is_regular(n.a) && (n.b < 0 || is_regular(n.b));
}

/// Returns true if the node is a sum of terms that contain a power of sin θ.
bool SingularTerms::vanishes(std::int32_t node) {
    if (!has_textbook_variables(node)) return false;
    Monomial denominator;
    const std::optional<Polynomial> p = cleared(expanded_sum(node), denominator);
    if (!p || p->empty()) return false;
    const int in_denominator = power_of(denominator, atom_sin_theta);
    return std::ranges::all_of(*p, [&](const auto& term) {
        return power_of(term.first, atom_sin_theta) > in_denominator;
    });
}

/// Returns the expansion of a node, in which regular sums are atoms.
const Polynomial& SingularTerms::expanded(std::int32_t node) {
    if (const auto known = expanded_.find(node); known != expanded_.end()) return known->second;
    Polynomial p = expansion(node);
    if (!is_usable(p)) p = atom_polynomial(representative(node));
    return expanded_[node] = std::move(p);
}

Polynomial SingularTerms::expansion(std::int32_t node) {
    const FormulaNode& n = at(node);
    const auto is_of_theta = [&] { return is(at(n.a), Textbook::theta); };
    switch (n.op) {
        case Op::constant: return n.value == 0 ? Polynomial{} : Polynomial{{{}, n.value}};
        case Op::input:
            if (is(n, Textbook::r)) return atom_polynomial(atom_r);
            if (is(n, Textbook::pphi)) return atom_polynomial(atom_pphi);
            if (is(n, Textbook::L2)) return atom_polynomial(atom_L2);
            if (is(n, Textbook::rho)) return {{{{atom_r, 1}, {atom_sin_theta, 1}}, 1}};
            if (is(n, Textbook::pr)) return atom_polynomial(atom_pr);
            // pρ = pr sin θ + pθ cos θ/r
            if (is(n, Textbook::prho))
                return {{{{atom_pr, 1}, {atom_sin_theta, 1}}, 1},
                        {{{atom_torque, 1}, {atom_cos_theta, 1}, {atom_sin_theta, -1}, {atom_r, -1}}, 1}};
            if (is(n, Textbook::ptheta)) return {{{{atom_torque, 1}, {atom_sin_theta, -1}}, 1}};
            break;
        case Op::sin:
            if (is_of_theta()) return atom_polynomial(atom_sin_theta);
            break;
        case Op::cos:
            if (is_of_theta()) return atom_polynomial(atom_cos_theta);
            break;
        case Op::tan:
            if (is_of_theta()) return {{{{atom_sin_theta, 1}, {atom_cos_theta, -1}}, 1}};
            break;
        case Op::neg:
        case Op::add:
        case Op::sub:
            if (n.op == Op::neg || !is_regular(node)) return expanded_sum(node);
            break;
        case Op::mul: return bounded_product(expanded(n.a), expanded(n.b));
        case Op::div: return product(expanded(n.a), inverse(n.b));
        default: break;
    }
    return atom_polynomial(representative(node));
}

/// Returns the expansion of a node. If it is a sum, it is expanded even if it is regular.
const Polynomial& SingularTerms::expanded_sum(std::int32_t node) {
    const FormulaNode& n = at(node);
    if (n.op != Op::neg && !is_sum(node)) return expanded(node);
    if (const auto known = expanded_sums_.find(node); known != expanded_sums_.end()) return known->second;
    Polynomial sum;
    add_to(sum, expanded_sum(n.a), n.op == Op::neg ? -1 : 1);
    if (n.op != Op::neg) add_to(sum, expanded_sum(n.b), n.op == Op::add ? 1 : -1);
    if (!is_usable(sum)) sum = atom_polynomial(representative(node));
    return expanded_sums_[node] = std::move(sum);
}

/// Returns 1/node. A sum such as 1 − cos²θ is replaced by the term sin²θ.
Polynomial SingularTerms::inverse(std::int32_t node) {
    const auto inverted = [](const Monomial& monomial, double coefficient) {
        Monomial result = monomial;
        for (auto& [atom, power] : result) power = -power;
        return Polynomial{{result, 1 / coefficient}};
    };
    const bool is_singular = has_textbook_variables(node) && vanishes(node);
    const Polynomial p = is_singular ? with_square(expanded_sum(node), atom_cos_theta, cosine_squared) : expanded(node);
    if (p.size() == 1) return inverted(p.begin()->first, p.begin()->second);
    return atom_polynomial(representative(node), -1);
}

/// Expands all sums in a polynomial, and multiplies it by the denominators of all terms. `denominator` is multiplied by
/// the same factors. The squares of cos θ and of pθ sin θ are replaced by terms in sin θ. Returns nothing if the
/// polynomial becomes too large.
std::optional<Polynomial> SingularTerms::cleared(Polynomial p, Monomial& denominator) {
    constexpr int max_rounds = 100;
    for (int round = 0; round < max_rounds; ++round) {
        Monomial factor;
        std::optional<std::int32_t> sum;
        for (const auto& [monomial, coefficient] : p)
            for (const auto& [atom, power] : monomial) {
                if (power < 0) factor[atom] = std::max(power_of(factor, atom), -power);
                else if (is_sum(atom)) sum = atom;
            }
        p = product(p, Polynomial{{factor, 1}});
        denominator = product(denominator, factor);
        if (!is_usable(p)) return std::nullopt;
        if (!sum) {
            p = with_square(with_square(p, atom_cos_theta, cosine_squared), atom_torque, torque_squared);
            return is_usable(p) ? std::optional(p) : std::nullopt;
        }
        const Polynomial terms = expanded_sum(*sum);
        if (terms == atom_polynomial(*sum)) return std::nullopt;
        Polynomial next;
        for (const auto& [monomial, coefficient] : p) {
            const int power = std::max(0, power_of(monomial, *sum));
            Polynomial term{{product(monomial, atom_to(*sum, -power)), coefficient}};
            for (int i = 0; i < power && is_usable(term); ++i) term = bounded_product(term, terms);
            add_to(next, term);
        }
        p = std::move(next);
    }
    return std::nullopt;
}

std::optional<Polynomial> SingularTerms::regularized(std::int32_t node) {
    const Polynomial p = with_square(expanded_sum(node), atom_torque, torque_squared);
    if (p == atom_polynomial(representative(node)) || !is_usable(p)) return std::nullopt;
    Polynomial regular, singular;
    for (const auto& term : p) (is_regular_term(term.first) ? regular : singular).insert(term);
    Monomial denominator;
    const std::optional<Polynomial> numerator = cleared(std::move(singular), denominator);
    if (!numerator) return std::nullopt;
    for (auto& [atom, power] : denominator) power = -power;
    const Polynomial rest = product(*numerator, Polynomial{{denominator, 1}});
    if (!std::ranges::all_of(rest, [](const auto& term) { return is_regular_term(term.first); })) return std::nullopt;
    add_to(regular, rest);
    return regular;
}

}  // namespace kagero
