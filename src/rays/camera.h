/// From a place on the picture to the ray that is seen there.
#pragma once

#include "plan/plan.h"

namespace kagero {

/// The ray seen at (u, v) of the picture, in pixels from its top left corner.
CameraRay camera_ray(const Plan& plan, double u, double v);

/// The direction, of any length, that the observer sees at (u, v). Not for parallel rays.
Double3 camera_direction(const Plan& plan, double u, double v);

/// The canonical state of the ray through any point of the film, in pixels from its upper left corner.
RayStart film_ray(const Plan& plan, double x, double y);
/// The same through the middle of a pixel.
RayStart pixel_ray(const Plan& plan, std::uint32_t x, std::uint32_t y);

}  // namespace kagero
