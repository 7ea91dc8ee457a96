/// Hamiltonians written in a scene: parsed here, differentiated and evaluated by the kernels.
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

inline constexpr std::array formula_variables{"x", "y", "z", "px", "py", "pz", "pt"};
/// The values of these variables.
using FormulaPoint = std::array<double, formula_variables.size()>;

}  // namespace kagero
