/// From the text of a formula to nodes.
///
///     expression = term { (+|-) term }      term  = factor { (*|/) factor }
///     factor     = (+|-) factor | power     power = primary [ ^ factor ]
///     primary    = number | name | function ( expression , … ) | ( expression )
///
/// So −x^2 = −(x²) and 2^3^2 = 2⁹. Powers with whole exponents become products, with half ones square roots; others
/// exp(b log a).
#pragma once

#include "formula/formula.h"

namespace kagero {

/// Gives a constant or a helper a name. Throws InputError for one that is taken, or is no name.
void define(FormulaScope& scope, const std::string& name, std::int32_t node, const Place& place);

/// Appends the nodes of a formula and returns the last of them. Throws InputError with place, position, and a line with
/// a caret.
std::int32_t parse_formula(FormulaScope& scope, const FormulaText& formula);

}  // namespace kagero
