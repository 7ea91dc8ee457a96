/// A black hole and steps that are too long, methods that are too rough, rays that go the wrong way.
#pragma once

#include "stability/trial.h"

namespace kagero::stability {

void captured_stay(Trial&);
void wrong_time_momentum(Trial&);
void unsolvable_step(Trial&);
void coarse_steps(Trial&);

}  // namespace kagero::stability
