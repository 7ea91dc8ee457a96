/// Loads the keys of a space whose Hamiltonian is a formula.
#pragma once

#include "scene/reader.h"

#include <optional>

namespace kagero {

/// Loads the table of a space with hamiltonian = "formula", and its tables `constants` and `let`. `other_keys` are
/// legal keys of the table that the caller reads.
FormulaDescription load_formula(const Section& section, const std::vector<std::string>& other_keys);

/// Returns the same formula with parameters in place of the named constants of its table `constants`. Parameter i is
/// the constant names[i]; its value in the nodes is that of the constant. The parts H_A and H_B and integrator.rescale
/// are left out.
FormulaDescription with_parameters(const FormulaDescription& formula, const std::vector<std::string>& names);

/// Reads an optional key whose value is a velocity: an array of three numbers or formulas in x y z. The formulas may
/// use the names in [space.constants] and [space.let], which are then recorded as used.
std::optional<VelocityDescription> load_velocity(const Section& section, const std::string& key,
                                                 SpaceDescription& space);

/// Parses the key `rescale` of an integrator, whose full name is `name`, unless it is "auto" or "none". The expression
/// may use x, y, z, r (the distance from the centre of the space), and the names in the tables `constants` and `let` of
/// the space. The parsed expression is stored in `space.formula`, or in `integrator.rescaling` if the Hamiltonian is
/// built in.
void load_rescaling(const Value& rescale, const std::string& name, SpaceDescription& space,
                    IntegratorDescription& integrator);

}  // namespace kagero
