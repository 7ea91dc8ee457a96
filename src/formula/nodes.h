/// Creates and evaluates the nodes of formulas. Functions that append nodes return the index of the result.
#pragma once

#include "formula/formula.h"

namespace kagero {

/// Returns a scope with the names x, y, z, px, py, pz, pt and pi.
FormulaScope formula_scope();

/// Appends a constant.
std::int32_t number_node(FormulaScope& scope, double value);

/// Appends a parameter with its number and its present value.
std::int32_t parameter_node(FormulaScope& scope, std::int32_t number, double value);

/// Appends an operation with one operand (b = −1) or two. If all operands are constant, the result is a constant, which
/// is not necessarily finite.
std::int32_t operation(FormulaScope& scope, Op op, std::int32_t a, std::int32_t b = -1);

/// Appends base^exponent: a product for whole exponents, a product with a square root for half-integer exponents, and
/// exp(exponent · log(base)) otherwise.
std::int32_t power(FormulaScope& scope, std::int32_t base, std::int32_t exponent);

/// Appends where(condition, a, b): a where the condition is greater than 0, else b; NaN where the condition is NaN.
std::int32_t branch(FormulaScope& scope, std::int32_t condition, std::int32_t a, std::int32_t b);

/// Returns the node of the textbook variable with this name, or −1 if there is none.
std::int32_t textbook_node(FormulaScope& scope, const std::string& name);

/// Returns the value of a node for the given values of the variables.
double evaluate(const FormulaScope& scope, std::int32_t node, const FormulaPoint& variables);

/// Returns the result of an operation on numbers. b is ignored if the operation has one operand.
double apply(Op op, double a, double b);

}  // namespace kagero
