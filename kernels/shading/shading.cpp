#include "kernels/shading/shading.h"

#include "kernels/shading/cell.h"
#include "kernels/shading/planck.h"
#include "kernels/shading/sky_points.h"

namespace kagero {
namespace {

using ShadingLanes = Lanes<double, 2>;
using ColorLanes = Lanes<float, 1>;
static_assert(shading_lanes % lane_count<ShadingLanes> == 0);

}  // namespace

void sky_footprints(const SkyBlocks* blocks) {
    for (std::uint32_t i = 0; i < blocks->count; i += lane_count<ShadingLanes>)
        shading::compute_footprints<ShadingLanes>(*blocks, i);
}

void sky_points(const SkyPoints* points) {
    for (std::uint32_t i = 0; i < points->count; i += lane_count<ShadingLanes>)
        shading::compute_points<ShadingLanes>(*points, i);
}

void planck_sums(const PlanckSums* planck) {
    for (std::uint32_t i = 0; i < planck->count; i += lane_count<ShadingLanes>)
        shading::compute_planck_sums<ShadingLanes>(*planck, i);
}

void shade_cell(const ShadedCell* cell) {
    shading::CellColors<ColorLanes>(*cell).write();
}

}  // namespace kagero
