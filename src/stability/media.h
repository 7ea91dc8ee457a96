/// Stability cases in media: layers, lenses, fibres, and an index that falls to zero.
#pragma once

#include "stability/case_run.h"

namespace kagero::stability {

// Each function runs one case of the table in stability.cpp.
void layer_refraction(CaseRun&);
void layer_momentum(CaseRun&);
void lens_surface(CaseRun&);
void vanishing_index(CaseRun&);
void long_fiber(CaseRun&);
void trapped(CaseRun&);

}  // namespace kagero::stability
