/// Rays between two fates: the photon sphere, the horizon, a wormhole's throat.
#pragma once

#include "stability/trial.h"

namespace kagero::stability {

void photon_sphere(Trial&);
void near_critical(Trial&);
void near_horizon(Trial&);
void inside(Trial&);
void throat(Trial&);

}  // namespace kagero::stability
