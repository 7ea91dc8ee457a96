/// The charts of the rays near a black hole: outgoing or ingoing coordinates (kernels/observers/charts.h).
///
/// The scene is in outgoing coordinates outside the horizon, and in ingoing coordinates inside it. Rays of a falling
/// observer near the horizon start in ingoing coordinates, which are regular for them. So do rays of any observer near
/// the horizon of a spinning hole, around which light winds up in outgoing coordinates.
#pragma once

#include "geometry/geometry.h"
#include "modules/space.h"

#include <optional>

namespace kagero {

/// Returns the horizon of a black hole; nothing if the space has none.
std::optional<Spheroid> horizon_of(const Space& space);
/// Returns the horizon of a spinning hole; nothing if the space has none. Kernels get the objects inside this spheroid
/// reflected.
std::optional<Spheroid> horizon_of_spinning_hole(const Space& space);
/// Returns true if q, relative to the centre of the space, is inside the horizon of a black hole or on it.
bool is_inside_horizon(const Space& space, const double (&q)[3]);

/// Returns true if the hole spins so fast that prograde light can turn close to the horizon. In outgoing coordinates,
/// such light would wind up. Rays therefore change their chart where they turn.
bool is_nearly_extreme(const Space& space);

/// Returns the radius |q| of the sphere inside which rays may be in ingoing coordinates: 2 r₊, or less if a surface
/// outside the horizon is closer. Returns 0 if there is no black hole, or if a surface almost touches the horizon.
double chart_radius(const Space& space, const SceneGeometry& geometry);

/// Returns true if the rays of an observer at q start in ingoing coordinates. Without an observer, rays inside the
/// horizon are in outgoing coordinates.
bool starts_ingoing(const Space& space, double chart_radius, std::optional<ObserverKind> observer,
                    const double (&q)[3]);

/// Returns the position of a ray's start in the coordinates of the scene, relative to the centre of the space.
Double3 start_position(const Space& space, const RayStart& start);

/// Throws InputError if an object lies inside a horizon although the camera is outside, or if it touches the horizon of
/// a spinning hole and the camera is inside. `camera` is the position of the camera relative to the centre of the
/// space, or nullptr for a ray list. `unit` is the unit of length in units of the scene file.
void check_surfaces_at_horizon(const Space& space, const SceneGeometry& geometry,
                               const std::vector<ObjectDescription>& objects, const double* camera, double unit);

}  // namespace kagero
