/// Loads the keys of a space whose Hamiltonian is a formula.
#pragma once

#include "scene/reader.h"

#include <optional>

namespace kagero {

/// Loads the tables [space] with hamiltonian = "formula", [space.constants] and [space.let].
FormulaDescription load_formula(const Section& section);

/// Reads an optional key whose value is a velocity: an array of three numbers or formulas in x y z. The formulas may
/// use the names in [space.constants] and [space.let], which are then recorded as used.
std::optional<VelocityDescription> load_velocity(const Section& section, const std::string& key,
                                                 SpaceDescription& space);

/// Parses `integrator.rescale`, unless it is "auto" or "none". The expression may use x, y, z, r (the distance from the
/// centre of the space), and the names in [space.constants] and [space.let]. The parsed expression is stored in
/// `space.formula`, or in `integrator.rescaling` if the Hamiltonian is built in.
void load_rescaling(const Value& rescale, SpaceDescription& space, IntegratorDescription& integrator);

}  // namespace kagero
