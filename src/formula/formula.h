/// Hamiltonians written in a scene: parsed here, differentiated and evaluated by the kernels.
///
///     expression = term { (+|-) term }      term  = factor { (*|/) factor }
///     factor     = (+|-) factor | power     power = primary [ ^ factor ]
///     primary    = number | name | function ( expression , … ) | ( expression )
///
/// So −x^2 = −(x²) and 2^3^2 = 2⁹. Powers with whole exponents become products, with half ones square roots; others exp(b log a).
#pragma once

#include "error.h"
#include "kernels/abi.h"

#include <array>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace kagero {

/// A formula and where it is written; `name` is the key that messages give, "space.H".
struct FormulaText {
    std::string text, name;
    Place place;
};

/// The names that formulas of one space may use, and the nodes that they share. Names stand for nodes.
struct FormulaScope {
    std::vector<FormulaNode> nodes;
    std::vector<std::pair<std::string, std::int32_t>> names;
    std::vector<std::uint8_t> variables;  ///< of each node: bit i where it depends on variable i
    std::set<std::string> used;           ///< names that some formula has
};

inline constexpr std::array<const char*, 7> formula_variables{"x", "y", "z", "px", "py", "pz", "pt"};

/// x y z px py pz pt and pi.
FormulaScope formula_scope();

/// Gives a constant or a helper a name. Throws InputError for one that is taken, or is no name.
void define(FormulaScope& scope, const std::string& name, std::int32_t node, const Place& place);

std::int32_t number_node(FormulaScope& scope, double value);

/// Appends the nodes of a formula and returns the last of them. Throws InputError with place, position, and a line with a caret.
std::int32_t parse_formula(FormulaScope& scope, const FormulaText& formula);

/// The value of a node.
double evaluate(const FormulaScope& scope, std::int32_t node, const std::array<double, 7>& variables);

}  // namespace kagero
