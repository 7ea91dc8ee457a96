/// Compilation of a scene's formulas to programs for the kernels, and the map from directions to momenta for a formula.
#pragma once

#include "modules/space.h"
#include "scene/description.h"

#include <optional>

namespace kagero {

/// Returns the programs of a formula. `size` is the greatest distance of rays from the origin. `for_comparison` is
/// Formula::for_comparison. Throws InputError if the formula is too large.
std::vector<double> compile_formula(const FormulaDescription& formula, const Module& module, double size,
                                    bool for_comparison);

/// Sets the values of the parameters in a formula with parameters, and in its programs in `space`.
void set_parameters(FormulaDescription& formula, const double* values, Space& space);

/// Returns true if H has kinks: if it depends on a min, max, abs or where.
bool has_kinks(const FormulaDescription& formula);

/// Returns the programs of Ω(H − H0), where H is a built-in Hamiltonian and Ω is the expression `integrator.rescale`.
/// Throws InputError if the programs are too large.
std::vector<double> compile_rescaled(const IntegratorDescription& integrator, const Space& space, bool for_comparison);

/// Returns the programs of a built-in Hamiltonian for comparison, with the Ω that it declares if `rescaled` is set.
/// Throws InputError if they are too large.
std::vector<double> record_space(const Space& space, bool rescaled);

/// Returns |dq/dλ| = |∂H/∂p| at the start of a ray, from differences of H.
double speed_of(const FormulaDescription& formula, const RayStart& ray);

/// The values of H before and behind a jump.
struct Jump {
    double before, behind;
};
/// Returns the jump of H on which a ray has ended. `end` lies just before the jump, in the coordinates of the kernels.
/// Empty if H does not jump there.
std::optional<Jump> jump_at(const FormulaDescription& formula, const RayEnd& end);

/// Returns the map from directions d at q to momenta p, for a Hamiltonian H = ½ p·G p + g·p + c that is quadratic in p.
/// A ray has the direction d if dq/dλ = ∂H/∂p = G p + g = μ d with a factor μ > 0. Then p = μ G⁻¹ d − G⁻¹ g, and H = H0
/// requires μ² d·G⁻¹ d = 2 (H0 − c) + g·G⁻¹ g. The map is meaningless if H is not quadratic in p. `pt` is the momentum
/// p_t of every ray.
StartMap quadratic_map(const FormulaDescription& formula, const double (&q)[3], double pt);

}  // namespace kagero
