/// The keys of a space whose Hamiltonian is written in the scene.
#pragma once

#include "scene/reader.h"

namespace kagero {

/// [space] with hamiltonian = "formula", [space.constants] and [space.let].
FormulaDescription load_formula(const Section& section);

/// An expression for `integrator.rescale`, in x y z, r, the distance from the space's centre, and the names of a
/// formula. "auto" and "none" are none.
void load_rescaling(const Value& rescale, SpaceDescription& space, IntegratorDescription& integrator);

}  // namespace kagero
