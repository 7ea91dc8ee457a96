/// Removes terms that are singular on the axis and cancel each other.
#pragma once

#include "formula/formula.h"
#include "formula/polynomial.h"

#include <optional>
#include <vector>

namespace kagero {

/// Atoms of polynomials other than nodes. All others are indices of nodes.
enum Atom : std::int32_t {
    atom_sin_theta = -1,
    atom_cos_theta = -2,
    atom_torque = -3,  ///< pθ sin θ, a regular function of x and p
    atom_r = -4,
    atom_pphi = -5,
    atom_L2 = -6,
    atom_pr = -7
};

/// Expands nodes with textbook variables to polynomials.
class SingularTerms {
public:
    explicit SingularTerms(const FormulaScope& scope) : scope_(scope) {}

    /// Returns true if a node has no term that is singular or not differentiable on the axis, such as an odd power of
    /// sin θ. The textbook variables in it can be replaced one by one.
    bool is_regular(std::int32_t node);

    /// Returns a sum or product as a polynomial without singular terms, or nothing if singular terms remain.
    std::optional<Polynomial> regularized(std::int32_t node);

    /// Returns true if both nodes are the same expression.
    bool equal(std::int32_t a, std::int32_t b) { return representative(a) == representative(b); }

    /// Returns the textbook variable of a node, if it is one.
    static bool is(const FormulaNode& node, Textbook variable) {
        return node.op == Op::input && node.a == static_cast<std::int32_t>(variable);
    }

private:
    const FormulaNode& at(std::int32_t node) const { return scope_.nodes[static_cast<std::size_t>(node)]; }
    bool has_textbook_variables(std::int32_t node) const;
    bool is_sum(std::int32_t atom) const;
    std::int32_t representative(std::int32_t node);
    bool find_regular(std::int32_t node);
    bool vanishes(std::int32_t node);
    const Polynomial& expanded(std::int32_t node);
    Polynomial expansion(std::int32_t node);
    const Polynomial& expanded_sum(std::int32_t node);
    Polynomial inverse(std::int32_t node);
    std::optional<Polynomial> cleared(Polynomial p, Monomial& denominator);

    const FormulaScope& scope_;
    std::map<std::array<double, 4>, std::int32_t> representatives_;  ///< The first node with an operation and operands.
    std::map<std::int32_t, std::int32_t> representative_of_;
    std::map<std::int32_t, bool> regular_;
    std::map<std::int32_t, Polynomial> expanded_, expanded_sums_;
};

}  // namespace kagero
