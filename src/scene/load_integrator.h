/// The table [integrator], and what a space gets that states no method or step.
#pragma once

#include "scene/reader.h"

namespace kagero {

/// An expression for `rescale` goes to the formula of the space.
IntegratorDescription load_integrator(const Section& section, SpaceDescription& space, const Catalogue& catalogue);

}  // namespace kagero
