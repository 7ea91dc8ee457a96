/// Stability cases with invalid input, grazing rays, and pictures that are known exactly.
#pragma once

#include "stability/case_run.h"

namespace kagero::stability {

// Each function runs one case of the table in stability.cpp.
void unusable_input(CaseRun&);
void grazing(CaseRun&);
void straight_picture(CaseRun&);

}  // namespace kagero::stability
