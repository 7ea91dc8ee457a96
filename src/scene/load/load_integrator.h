/// Loads the table [integrator], with the default method and step of the space.
#pragma once

#include "scene/reader.h"

namespace kagero {

/// Returns the default steps, indexed by StepKind.
///
/// A default step is proportional to the length that the Hamiltonian declares (`step_goes_with`). It is also
/// proportional to the inverse of the index of refraction, so that the distance covered by a step does not depend on
/// the index. It is at most escape_radius, which limits the steps in a medium that hardly bends light. For a spacetime
/// that declares Ω, the declared step is that of the rescaled H. The step without rescaling is then also proportional
/// to the first parameter of the Hamiltonian that is a length.
std::array<double, 3> default_steps(const HamiltonianInfo& info, const SpaceDescription& space, double escape_radius);

/// Loads the table [integrator] or [medium.integrator]. If the Hamiltonian is a formula, the parsed `rescale` is stored
/// in `space.formula`.
IntegratorDescription load_integrator(const Section& section, SpaceDescription& space, const Catalogue& catalogue,
                                      double default_escape_radius = IntegratorDescription().escape_radius);

}  // namespace kagero
