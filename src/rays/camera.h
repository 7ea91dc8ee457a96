/// Cameras: from a place on the picture to the ray that is seen there.
#pragma once

#include "plan/plan.h"

namespace kagero {

/// A ray and what its observer makes of its frequency.
struct CameraRay {
    RayStart start;
    double frequency;  ///< p · u of the observer: the frequency seen, where p is the momentum that `start` has
};

/// Points the plan's camera and asks the space for the observer there. Throws InputError where there can be none.
void place_camera(Plan& plan);

/// Whether the plan's precision is too low for the camera's place (see needs_double).
bool camera_needs_double(const Plan& plan);

/// The ray seen at (u, v) of the picture, in pixels from its top left corner.
CameraRay camera_ray(const Plan& plan, double u, double v);

/// The rest frame of an observer at q.
Failure observe(const Plan& plan, ObserverKind kind, const double (&q)[3], StartMap& map);

/// A ray in direction d, of any length, of the rest frame that `map` belongs to.
CameraRay ray_in_frame(const StartMap& map, const double (&q)[3], const Double3& d);

/// How large a pixel of the scene's camera is at a distance.
double pixel_size(const SceneDescription& scene, double distance);

/// The direction, of any length, that the observer sees at (u, v). Not of parallel rays.
Double3 camera_direction(const Plan& plan, double u, double v);

/// Whether the kernels can make the rays themselves: one through the middle of each pixel of a perspective camera.
bool kernel_makes_rays(const Plan& plan);

}  // namespace kagero
