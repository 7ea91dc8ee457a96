/// Data of the formulas in a scene. The folder src/formula parses them; the kernels differentiate and evaluate them.
#pragma once

#include "error.h"
#include "kernels/abi.h"

#include <array>
#include <map>
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
    /// Bits of the variables on which the formula may depend, as in FormulaScope::variables. Messages about unknown
    /// names suggest only legal ones.
    unsigned allowed = 0b1111111;
};

/// The variables of formulas, in the order of FormulaPoint and of the bits of FormulaScope::variables.
inline constexpr std::array formula_variables{"x", "y", "z", "px", "py", "pz", "pt"};
/// The values of the variables.
using FormulaPoint = std::array<double, formula_variables.size()>;

/// The spherical and cylindrical coordinates of x y z, their momenta, and L² = |x × p|². Unless the scene defines other
/// meanings of these names, they are further variables while a formula is parsed; textbook_coordinates.h replaces them.
enum class Textbook : std::int32_t { r = formula_variables.size(), theta, phi, rho, pr, ptheta, pphi, L2, prho };
struct TextbookVariable {
    const char* name;
    std::uint8_t depends_on;  ///< Bits of FormulaScope::variables.
};
inline constexpr TextbookVariable textbook_variables[] = {{"r", 0b0000111},    {"theta", 0b0000111},
                                                          {"phi", 0b0000011},  {"rho", 0b0000011},
                                                          {"pr", 0b0111111},   {"ptheta", 0b0111111},
                                                          {"pphi", 0b0011011}, {"L2", 0b0111111},
                                                          {"prho", 0b0011011}};

/// The names that the formulas of one space may use, and the nodes that these formulas share. Each name refers to a
/// node.
struct FormulaScope {
    /// This bit of `variables` is set if a node depends on textbook variables.
    static constexpr std::uint8_t textbook_bit = 1u << formula_variables.size();

    std::vector<FormulaNode> nodes;
    std::vector<std::pair<std::string, std::int32_t>> names;
    std::vector<std::uint8_t> variables;  ///< For each node: bit i is set if the node depends on variable i.
    std::set<std::string> used_names;     ///< Names that at least one formula uses.
    std::map<std::string, std::int32_t> textbook_nodes;   ///< Nodes of the textbook variables that a formula uses.
    std::map<std::int32_t, std::int32_t> cartesian_nodes;  ///< Nodes that replace nodes with textbook variables.
    /// True if a power has an exponent that depends on parameters. It is then computed by the logarithm of its base,
    /// also where the exponent is a whole number.
    bool has_parameter_exponent = false;
};

}  // namespace kagero
