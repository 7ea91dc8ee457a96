/// The cases, one function each; `cases.cpp` has their table.
#pragma once

#include "stability/trial.h"

namespace kagero::stability {

// media.cpp
void layer_refraction(Trial&);
void layer_momentum(Trial&);
void lens_surface(Trial&);
void vanishing_index(Trial&);
void long_fiber(Trial&);
void trapped(Trial&);

// critical.cpp
void photon_sphere(Trial&);
void near_critical(Trial&);
void near_horizon(Trial&);
void inside(Trial&);
void throat(Trial&);

// holes.cpp
void captured_stay(Trial&);
void wrong_time_momentum(Trial&);
void unsolvable_step(Trial&);
void coarse_steps(Trial&);

// numbers.cpp
void scaled_scene(Trial&);
void denormals(Trial&);
void float_floor(Trial&);

// scenes.cpp
void unusable_input(Trial&);
void grazing(Trial&);
void straight_picture(Trial&);

}  // namespace kagero::stability
