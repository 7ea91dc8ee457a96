/// What spaces with a formula need beside the others.
#pragma once

#include "plan/plan.h"

namespace kagero {

/// The programs of a formula. Throws InputError for one that is too large.
std::vector<double> compile_formula(const FormulaDescription& formula, const Module& module);

/// The programs of a compiled Hamiltonian that the scene rescales by an expression. Throws InputError for one that cannot be.
std::vector<double> compile_rescaled(const RescalingDescription& rescaling, const Plan& plan);

/// The state of a ray that moves along d from q, in coordinates.
RayStart formula_ray(const Plan& plan, const double (&q)[3], const Double3& d);

/// For a camera at rest in the coordinates of what is no spacetime: a map from directions to momenta if H is quadratic in p; else
/// Plan::each_direction is set.
Failure place_formula_camera(Plan& plan, StartMap& map);

}  // namespace kagero
