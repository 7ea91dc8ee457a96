/// The keys of a space whose Hamiltonian is written in the scene.
#pragma once

#include "scene/reader.h"

namespace kagero {

/// [space] with hamiltonian = "formula", [space.constants] and [space.let].
FormulaDescription load_formula(const Section& section);

/// An expression for `integrator.rescale`, in the names of the space and r, the distance from its centre. "auto" and "none" are none.
void load_rescaling(const Value& rescale, FormulaDescription& formula);

}  // namespace kagero
