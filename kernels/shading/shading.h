/// The functions of the module for shading.
#pragma once

#include "kernels/shading.h"

namespace kagero {

void sky_footprints(const SkyBlocks* blocks);
void sky_points(const SkyPoints* points);
void planck_sums(const PlanckSums* planck);
void shade_cell(const ShadedCell* cell);

inline constexpr ShadingFunctions shading_functions{sky_footprints, sky_points, planck_sums, shade_cell};

}  // namespace kagero
