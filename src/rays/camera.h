/// Rays of the camera. Points (x, y) of the picture are in pixels from its upper left corner; x increases to the right
/// and y downward. The centre of pixel (0, 0) is the point (½, ½).
#pragma once

#include "plan/plan.h"

namespace kagero {

/// Returns the ray through the point (x, y): its start, and the frequency of its light for the observer.
CameraRay camera_ray(const Plan& plan, double x, double y);

/// Returns the ray through the point (x, y) of a camera with a thin lens, from a point of the lens: `lens` is a point
/// in the unit disk, along the right and downward. All rays of a point of the picture meet at camera.focus_distance in
/// front of the lens, in flat space. The rays start in the rest frame of the observer at their point of the lens.
CameraRay lens_ray(const Plan& plan, double x, double y, const std::array<double, 2>& lens);

/// Returns the start of the ray through the point (x, y).
RayStart camera_ray_start(const Plan& plan, double x, double y);

/// Returns the start of the ray through the centre of pixel (x, y).
RayStart pixel_ray_start(const Plan& plan, std::uint32_t x, std::uint32_t y);

/// Returns the direction of the ray through the point (x, y) in the observer's rest frame. The vector is not
/// normalized. The camera must not be orthographic, because each of its rays starts at another point, with another rest
/// frame.
Double3 camera_direction(const Plan& plan, double x, double y);

/// Returns the plan with all rays displaced by a vector on the picture, in pixels.
Plan with_displaced_rays(Plan plan, double x, double y);

}  // namespace kagero
