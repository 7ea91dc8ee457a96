/// What spaces with a formula need beside the others.
#pragma once

#include "render/plan.h"

namespace kagero {

/// The programs of a formula. Throws InputError for one that is too large.
std::vector<double> compile_formula(const FormulaDescription& formula, const Module& module);

/// The state of a ray that moves along d from q. Formulas know no observer but one at rest in the coordinates.
RayStart formula_ray(const Plan& plan, ObserverKind kind, const double (&q)[3], const Double3& d);

/// Gives the camera a map from directions to momenta if H is quadratic in p; else Plan::each_direction is set.
Failure place_formula_camera(Plan& plan);

}  // namespace kagero
