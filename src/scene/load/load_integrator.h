/// Loads the table [integrator], with the default method and step of the space.
#pragma once

#include "scene/reader.h"

namespace kagero {

/// Loads the table [integrator] or [medium.integrator]. If the Hamiltonian is a formula, the parsed `rescale` is stored
/// in `space.formula`.
IntegratorDescription load_integrator(const Section& section, SpaceDescription& space, const Catalogue& catalogue,
                                      double default_escape_radius = IntegratorDescription().escape_radius);

}  // namespace kagero
