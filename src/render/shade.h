/// Ends of rays to pixels.
#pragma once

#include "film/film.h"
#include "render/plan.h"

namespace kagero {

/// Writes what the film's layers want of one ray into pixel (x, y) of the film. The ray's positions are relative to `space.center`.
void shade(const Plan& plan, const RayEnd& end, Film& film, std::uint32_t x, std::uint32_t y);

}  // namespace kagero
