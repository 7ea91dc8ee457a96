/// Input that cannot be used, and pictures whose every pixel is known.
#pragma once

#include "stability/trial.h"

namespace kagero::stability {

void unusable_input(Trial&);
void grazing(Trial&);
void straight_picture(Trial&);

}  // namespace kagero::stability
