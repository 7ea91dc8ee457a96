/// The ray of one pixel: its path, its end, and the error of the end.
#pragma once

#include "plan/plan.h"
#include "report/json.h"

namespace kagero {

/// Traces the ray through the middle of a pixel. Returns its status, object, steps and errors, and the points of its
/// path in the coordinates of the scene file, from the start. The plan must have one ray per pixel, and the pixel must
/// lie in its film.
Json pixel_json(const Plan& plan, std::uint32_t x, std::uint32_t y);

}  // namespace kagero
