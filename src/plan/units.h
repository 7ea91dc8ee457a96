/// The unit of length of the kernels. Scenes of the size of atoms or galaxies are traced in a unit of similar size, so
/// that powers of lengths neither overflow nor underflow. The unit is a power of two, so that conversions are exact.
#pragma once

#include "scene/description.h"

namespace kagero {

/// Returns the unit of length of the kernels, in units of the scene file. It is 1 for scenes of ordinary size, and for
/// scenes in which a space or medium has a formula or an expression for Ω.
double length_unit(const SceneDescription& scene);

/// Converts all lengths of the scene and its media to `unit`, except steps, whose unit depends on the method.
void convert_lengths(SceneDescription& scene, const Module& module, double unit);

}  // namespace kagero
