/// Compilation of a scene's formulas to programs for the kernels, and the ray starts of a formula.
#pragma once

#include "modules/space.h"
#include "scene/description.h"

namespace kagero {

/// Returns the programs of a formula. Throws InputError if the formula is too large.
std::vector<double> compile_formula(const FormulaDescription& formula, const Module& module);

/// Returns the programs of a compiled Hamiltonian that the scene multiplies by an expression. Throws InputError if this
/// product cannot be compiled.
std::vector<double> compile_rescaled(const IntegratorDescription& integrator, const Space& space);

/// Returns the map from directions to momenta of a Hamiltonian H = ½ p·G p + g·p + c that is quadratic in p. From
/// ∂H/∂p = G p + g = μ d follows p = μ G⁻¹ d − G⁻¹ g. From H = H0 follows μ² d·G⁻¹ d = 2 (H0 − c) + g·G⁻¹ g. The map is
/// meaningless if H is not quadratic in p.
StartMap quadratic_map(const FormulaDescription& formula, const double (&q)[3], double pt);

}  // namespace kagero
