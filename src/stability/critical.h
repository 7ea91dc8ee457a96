/// Stability cases near a critical orbit: the photon sphere, the horizon, and the throat of a wormhole.
#pragma once

#include "stability/case_run.h"

namespace kagero::stability {

// Each function runs one case of the table in stability.cpp.
void photon_sphere(CaseRun&);
void near_critical(CaseRun&);
void near_horizon(CaseRun&);
void inside(CaseRun&);
void throat(CaseRun&);

}  // namespace kagero::stability
