/// Numbers at the edges of their range, and the number of digits.
#pragma once

#include "stability/trial.h"

namespace kagero::stability {

void scaled_scene(Trial&);
void denormals(Trial&);
void float_floor(Trial&);

}  // namespace kagero::stability
