/// Velocities that a scene states as numbers or formulas.
#pragma once

#include "scene/description.h"

namespace kagero {

/// Returns the velocity dq/dt at q, relative to `space.center`.
Double3 velocity_at(const VelocityDescription& velocity, const double (&q)[3]);

/// Returns the components as they are written in the scene, "[vx, vy, vz]". If they are formulas, the values at q
/// follow.
std::string text_of(const VelocityDescription& velocity, const double (&q)[3]);

}  // namespace kagero
