/// Comparison of the ends of two rays, in pixels of the film.
#pragma once

#include "plan/plan.h"

namespace kagero {

double distance_between(const double (&a)[3], const double (&b)[3]);

/// Returns the angle between two unit vectors. The arc sine is accurate for small angles, unlike the arc cosine.
double angle_between(const double (&a)[3], const double (&b)[3]);

/// Returns true if the end of a ray shows a surface or the sky, that is, if its status is `hit` or `escaped`.
bool has_visible_end(const RayEnd& end);

/// Returns true if the error of a ray end is an angle between directions, false if it is a distance between positions.
/// It is an angle for rays that hit nothing, except for an orthographic camera, whose pixels have no angle.
bool is_seen_by_direction(const Plan& plan, const RayEnd& end);

/// Returns the size of a film pixel at a ray end: an angle in radians if `is_seen_by_direction`, otherwise a length.
double pixel_size_at(const Plan& plan, const RayEnd& end);

/// Returns the distance between an expected and an actual ray end, in film pixels. If `is_seen_by_direction`, it is the
/// angle between the directions, otherwise the distance of the end points. Both ends must have the same status and
/// object. They must be in the coordinates of the Hamiltonian, as kernels write them.
double distance_in_pixels(const Plan& plan, const RayEnd& expected, const RayEnd& actual);

/// Returns true if both ends have the same status and, for `hit`, the same object.
bool same_status_and_object(const RayEnd& a, const RayEnd& b);

}  // namespace kagero
