/// Lengths as the kernels see them: scenes of atoms or galaxies are traced in a unit of their own size, a power of two,
/// so that no square of a length leaves the numbers, and nothing is rounded on the way.
#pragma once

#include "scene/description.h"

namespace kagero {

/// The length, in scene units, that the kernels take for 1: 1 for scenes of ordinary size and for formulas.
double length_unit(const SceneDescription& scene);

/// The scene with all lengths in that unit. The step keeps its unit, which depends on the method.
void measure_in(SceneDescription& scene, const HamiltonianInfo& info, double unit);

}  // namespace kagero
