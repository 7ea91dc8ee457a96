/// Formulas of a scene as programs of the kernels, and the starts of their rays.
#pragma once

#include "modules/space.h"
#include "scene/description.h"

namespace kagero {

/// The programs of a formula. Throws InputError for one that is too large.
std::vector<double> compile_formula(const FormulaDescription& formula, const Module& module);

/// The programs of a compiled Hamiltonian that the scene rescales by an expression. Throws InputError for one that
/// cannot be.
std::vector<double> compile_rescaled(const IntegratorDescription& integrator, const Space& space);

/// The map of an H quadratic in p, H = ½ p·G p + g·p + c: from ∂H/∂p = G p + g = μ d follows p = μ G⁻¹ d − G⁻¹ g, and
/// from H = H0 μ² d·G⁻¹ d = 2 (H0 − c) + g·G⁻¹ g. For any other H the map is meaningless.
StartMap quadratic_map(const FormulaDescription& formula, const double (&q)[3], double pt);

}  // namespace kagero
