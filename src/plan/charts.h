/// The charts of the rays near a black hole: outgoing or ingoing coordinates (kernels/observers/charts.h).
///
/// The scene is in outgoing coordinates outside the horizon, and in ingoing coordinates inside it. Rays of a falling
/// observer near the horizon start in ingoing coordinates, which are regular for them. So do rays of any observer near
/// the horizon of a spinning hole, around which light winds up in outgoing coordinates.
#pragma once

#include "plan/scene.h"
#include "plan/view.h"

#include <optional>

namespace kagero {

/// Returns true if q, relative to the centre of the space, is inside the horizon of a black hole or on it.
bool is_inside_horizon(const Scene& scene, const double (&q)[3]);

/// Returns the horizon of a spinning black hole; nothing if the space has none. Kernels get the objects inside this
/// spheroid reflected.
std::optional<Spheroid> horizon_of_spinning_hole(const Space& space);

/// Returns the radius |q| of the sphere inside which rays may be in ingoing coordinates: 2 r₊, or less if a surface
/// outside the horizon is closer. Returns 0 if there is no black hole, or if a surface almost touches the horizon.
double chart_radius(const Scene& scene);

/// Returns true if the rays of an observer at q start in ingoing coordinates. Without an observer, rays inside the
/// horizon are in outgoing coordinates.
bool starts_ingoing(const Scene& scene, std::optional<ObserverKind> observer, const double (&q)[3]);

/// Returns true if rays of this view change between ingoing and outgoing coordinates on their way. They need not if
/// they stay in outgoing coordinates, or if no surface lies on their way; ray ends are converted in any case. Near an
/// extreme hole, rays change their coordinates where they turn outward.
bool chart_changes_on_the_way(const Scene& scene, const View& view);

/// Throws InputError if an object lies inside the horizon although the camera is outside, or if it crosses the horizon
/// of a spinning hole.
void check_surfaces_at_horizon(const Scene& scene, Purpose purpose);

}  // namespace kagero
