/// Nodes made from operations: what is constant is evaluated at once, powers become products.
#pragma once

#include "formula/formula.h"

namespace kagero {

/// An operation of one operand (b = −1) or two. The result of constants is a number, which may not be finite.
std::int32_t operation(FormulaScope& scope, FormulaOp op, std::int32_t a, std::int32_t b = -1);

std::int32_t power(FormulaScope& scope, std::int32_t base, std::int32_t exponent);

/// One operation on numbers.
double apply(FormulaOp op, double a, double b);

}  // namespace kagero
