/// Parses the text of a formula into nodes. The grammar is
///
///     expression = term { (+|-) term }      term  = factor { (*|/) factor }
///     factor     = (+|-) factor | power     power = primary [ ^ factor ]
///     primary    = number | name | function ( expression { , expression } ) | ( expression )
///
/// Therefore −x^2 = −(x²) and 2^3^2 = 2⁹. Powers with whole exponents become products, those with half-integer
/// exponents contain a square root, and a^b is exp(b log a) otherwise.
#pragma once

#include "formula/formula.h"

namespace kagero {

/// Defines a name for a node, such as the name of a constant or a helper. Throws InputError with `location` if the name
/// is already defined or is not legal.
void define(FormulaScope& scope, const std::string& name, std::int32_t node, const FileLocation& location);

/// Appends the nodes of a formula and returns the index of its root. Textbook variables are replaced by expressions in
/// x y z px py pz. Throws InputError with the position in the file, the position in the formula, and a line with a
/// caret.
std::int32_t parse_formula(FormulaScope& scope, const FormulaText& formula);

/// The same for a formula that other formulas refer to. Textbook variables remain, so that terms of the referring
/// formulas can cancel.
std::int32_t parse_helper(FormulaScope& scope, const FormulaText& formula);

}  // namespace kagero
