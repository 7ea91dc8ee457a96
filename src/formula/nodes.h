/// Nodes made from operations: what is constant is evaluated at once, powers become products.
#pragma once

#include "formula/formula.h"

namespace kagero {

/// x y z px py pz pt and pi.
FormulaScope formula_scope();

std::int32_t number_node(FormulaScope& scope, double value);

/// An operation of one operand (b = −1) or two. The result of constants is a number, which may not be finite.
std::int32_t operation(FormulaScope& scope, Op op, std::int32_t a, std::int32_t b = -1);

std::int32_t power(FormulaScope& scope, std::int32_t base, std::int32_t exponent);

/// The value of a node.
double evaluate(const FormulaScope& scope, std::int32_t node, const FormulaPoint& variables);

/// One operation on numbers.
double apply(Op op, double a, double b);

}  // namespace kagero
