/// Stability cases around a black hole: steps that are too long, inaccurate methods, and a wrong sign of p_t.
#pragma once

#include "stability/case_run.h"

namespace kagero::stability {

// Each function runs one case of the table in stability.cpp.
void captured_stay(CaseRun&);
void wrong_time_momentum(CaseRun&);
void unsolvable_step(CaseRun&);
void coarse_steps(CaseRun&);

}  // namespace kagero::stability
