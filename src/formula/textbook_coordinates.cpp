#include "formula/textbook_coordinates.h"

#include "formula/nodes.h"
#include "formula/singular_terms.h"
#include "kernels/operation.h"

#include <cmath>

namespace kagero {
namespace {

class CartesianForm {
public:
    explicit CartesianForm(FormulaScope& scope) : scope_(scope), terms_(scope) {}

    /// Returns a node without textbook variables that equals `node`.
    std::int32_t of(std::int32_t node) {
        if (!(scope_.variables[static_cast<std::size_t>(node)] & FormulaScope::textbook_bit)) return node;
        if (const auto known = scope_.cartesian_nodes.find(node); known != scope_.cartesian_nodes.end())
            return known->second;
        const std::int32_t result = form_of(node);
        return scope_.cartesian_nodes[node] = result;
    }

private:
    FormulaNode at(std::int32_t node) const { return scope_.nodes[static_cast<std::size_t>(node)]; }
    std::int32_t name(const char* text) const {
        for (const auto& [known, node] : scope_.names)
            if (known == text) return node;
        return -1;
    }
    std::int32_t add(std::int32_t a, std::int32_t b) { return operation(scope_, Op::add, a, b); }
    std::int32_t sub(std::int32_t a, std::int32_t b) { return operation(scope_, Op::sub, a, b); }
    std::int32_t mul(std::int32_t a, std::int32_t b) { return operation(scope_, Op::mul, a, b); }
    std::int32_t div(std::int32_t a, std::int32_t b) { return operation(scope_, Op::div, a, b); }
    std::int32_t square(std::int32_t a) { return mul(a, a); }

    std::int32_t form_of(std::int32_t node);
    std::int32_t variable(Textbook which) {
        const auto [known, is_new] = variables_.try_emplace(which, -1);
        if (is_new) known->second = expression_of(which);
        return known->second;
    }
    std::int32_t expression_of(Textbook which);
    std::int32_t function_of_angle(Op function, bool of_theta);
    std::int32_t sum_of(Polynomial p);
    std::int32_t product_of(const Monomial& monomial, double coefficient);
    std::int32_t atom_node(std::int32_t atom);

    /// x y z px py pz.
    std::int32_t coordinate(std::size_t i) const { return name(formula_variables[i]); }
    /// The component `axis` of x × p.
    std::int32_t momentum_about(std::size_t axis) {
        const std::size_t i = (axis + 1) % 3, k = (axis + 2) % 3;
        return sub(mul(coordinate(i), coordinate(k + 3)), mul(coordinate(k), coordinate(i + 3)));
    }
    std::int32_t x_px_plus_y_py() {
        return add(mul(coordinate(0), coordinate(3)), mul(coordinate(1), coordinate(4)));
    }
    std::int32_t rho_squared() { return add(square(coordinate(0)), square(coordinate(1))); }
    std::int32_t r() { return variable(Textbook::r); }
    std::int32_t rho() { return variable(Textbook::rho); }
    /// pθ ρ = z (x px + y py) − ρ² pz.
    std::int32_t ptheta_rho() {
        return sub(mul(coordinate(2), x_px_plus_y_py()), mul(rho_squared(), coordinate(5)));
    }

    FormulaScope& scope_;
    SingularTerms terms_;
    std::map<Textbook, std::int32_t> variables_;  ///< Expressions that were appended.
};

std::int32_t CartesianForm::form_of(std::int32_t node) {
    const FormulaNode n = at(node);
    if (n.op == Op::input) return variable(static_cast<Textbook>(n.a));
    const FormulaNode operand = at(n.a);
    const bool of_theta = SingularTerms::is(operand, Textbook::theta),
               of_phi = SingularTerms::is(operand, Textbook::phi);
    if ((of_theta || of_phi) && (n.op == Op::sin || n.op == Op::cos || n.op == Op::tan))
        return function_of_angle(n.op, of_theta);
    if (n.op == Op::mul && terms_.equal(n.a, n.b)) {
        if (SingularTerms::is(operand, Textbook::rho)) return rho_squared();
        if (operand.op == Op::sin && SingularTerms::is(at(operand.a), Textbook::theta))
            return div(rho_squared(), add(rho_squared(), square(coordinate(2))));
    }
    const bool is_arithmetic = info_of(n.op).name[0] != '\0' && !info_of(n.op).has_function_name();
    if (is_arithmetic && !terms_.is_regular(node))
        if (std::optional<Polynomial> p = terms_.regularized(node)) return sum_of(std::move(*p));
    const std::int32_t a = of(n.a), b = n.b < 0 ? -1 : of(n.b);
    return operation(scope_, n.op, a, b);
}

/// Appends the expression of a textbook variable.
std::int32_t CartesianForm::expression_of(Textbook which) {
    switch (which) {
        case Textbook::r: return operation(scope_, Op::sqrt, add(rho_squared(), square(coordinate(2))));
        case Textbook::theta: return operation(scope_, Op::atan2, rho(), coordinate(2));
        case Textbook::phi: return operation(scope_, Op::atan2, coordinate(1), coordinate(0));
        case Textbook::rho: return operation(scope_, Op::sqrt, rho_squared());
        case Textbook::pr: return div(add(x_px_plus_y_py(), mul(coordinate(2), coordinate(5))), r());
        case Textbook::ptheta: return div(ptheta_rho(), rho());
        case Textbook::pphi: return momentum_about(2);
        case Textbook::prho: return div(x_px_plus_y_py(), rho());
        case Textbook::L2: break;
    }
    return add(add(square(momentum_about(0)), square(momentum_about(1))), square(momentum_about(2)));
}

/// Returns the sine, cosine or tangent of θ or φ.
std::int32_t CartesianForm::function_of_angle(Op function, bool of_theta) {
    const std::int32_t opposite = of_theta ? rho() : coordinate(1), adjacent = of_theta ? coordinate(2) : coordinate(0);
    if (function == Op::tan) return div(opposite, adjacent);
    return div(function == Op::sin ? opposite : adjacent, of_theta ? r() : rho());
}

std::int32_t CartesianForm::atom_node(std::int32_t atom) {
    switch (atom) {
        case atom_sin_theta: return function_of_angle(Op::sin, true);
        case atom_cos_theta: return function_of_angle(Op::cos, true);
        case atom_torque: return div(ptheta_rho(), r());
        case atom_r: return variable(Textbook::r);
        case atom_pphi: return variable(Textbook::pphi);
        case atom_L2: return variable(Textbook::L2);
        case atom_pr: return variable(Textbook::pr);
        default: return of(atom);
    }
}

/// Appends coefficient · monomial.
std::int32_t CartesianForm::product_of(const Monomial& monomial, double coefficient) {
    std::int32_t numerator = number_node(scope_, coefficient), denominator = -1;
    const auto multiply = [&](std::int32_t base, int exponent) {
        const bool is_above = exponent > 0;
        const std::int32_t factor = power(scope_, base, number_node(scope_, std::abs(exponent)));
        if (!is_above) denominator = denominator < 0 ? factor : mul(denominator, factor);
        else if (at(numerator).op == Op::constant && at(numerator).value == 1) numerator = factor;
        else numerator = mul(numerator, factor);
    };
    for (const auto& [atom, exponent] : monomial) {
        // sin²θ = ρ²/r²
        if (atom == atom_sin_theta) multiply(rho_squared(), exponent / 2);
        else multiply(atom_node(atom), exponent);
    }
    return denominator < 0 ? numerator : div(numerator, denominator);
}

/// Appends a polynomial that contains no odd power of sin θ.
std::int32_t CartesianForm::sum_of(Polynomial p) {
    Polynomial in_rho;
    for (const auto& [monomial, coefficient] : p) {
        const int sines = power_of(monomial, atom_sin_theta);
        in_rho[product(monomial, atom_to(atom_r, -sines))] = coefficient;
    }
    const Monomial common = common_factor(in_rho);
    std::int32_t sum = -1;
    for (const auto& [monomial, coefficient] : in_rho) {
        Monomial rest = monomial;
        for (const auto& [atom, exponent] : common) rest = product(rest, atom_to(atom, -exponent));
        if (sum < 0) sum = product_of(rest, coefficient);
        else if (coefficient < 0) sum = sub(sum, product_of(rest, -coefficient));
        else sum = add(sum, product_of(rest, coefficient));
    }
    if (sum < 0) return number_node(scope_, 0);
    std::int32_t above = sum, below = -1;
    Monomial numerators, denominators;
    for (const auto& [atom, exponent] : common) (exponent > 0 ? numerators : denominators)[atom] = std::abs(exponent);
    if (!numerators.empty()) above = mul(product_of(numerators, 1), sum);
    if (!denominators.empty()) below = product_of(denominators, 1);
    return below < 0 ? above : div(above, below);
}

}  // namespace

std::int32_t to_cartesian(FormulaScope& scope, std::int32_t node) { return CartesianForm(scope).of(node); }

}  // namespace kagero
