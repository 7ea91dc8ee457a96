/// Data of the formulas in a scene. The folder src/formula parses them; the kernels differentiate and evaluate them.
#pragma once

#include "error.h"
#include "kernels/abi.h"

#include <array>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace kagero {

/// The text of a formula and its position in the scene file.
struct FormulaText {
    std::string text;
    std::string name;  ///< Full name of the key, for messages: "space.H".
    FileLocation location;
};

/// The names that the formulas of one space may use, and the nodes that these formulas share. Each name refers to a
/// node.
struct FormulaScope {
    std::vector<FormulaNode> nodes;
    std::vector<std::pair<std::string, std::int32_t>> names;
    std::vector<std::uint8_t> variables;  ///< For each node: bit i is set if the node depends on variable i.
    std::set<std::string> used_names;     ///< Names that at least one formula uses.
};

/// The variables of formulas, in the order of FormulaPoint and of the bits of FormulaScope::variables.
inline constexpr std::array formula_variables{"x", "y", "z", "px", "py", "pz", "pt"};
/// The values of the variables.
using FormulaPoint = std::array<double, formula_variables.size()>;

}  // namespace kagero
