/// Stability cases of floating-point arithmetic: very large and small scales, denormals, and float precision.
#pragma once

#include "stability/case_run.h"

namespace kagero::stability {

// Each function runs one case of the table in stability.cpp.
void scaled_scene(CaseRun&);
void denormals(CaseRun&);
void float_floor(CaseRun&);

}  // namespace kagero::stability
