/// Index media: layers, lenses, fibres, and where the index ends.
#pragma once

#include "stability/trial.h"

namespace kagero::stability {

void layer_refraction(Trial&);
void layer_momentum(Trial&);
void lens_surface(Trial&);
void vanishing_index(Trial&);
void long_fiber(Trial&);
void trapped(Trial&);

}  // namespace kagero::stability
