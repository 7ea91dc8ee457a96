#include "tuning/trial_run.h"

#include "accuracy/sample_rays.h"
#include "rays/camera.h"
#include "render/trace.h"

namespace kagero {

RunReport trace_trial(Plan plan) {
    constexpr std::uint32_t grid = 8;  // rays along each edge of the film
    plan.run.outputs |= output_energy;
    std::vector<RayStart> starts;
    for (const auto& [x, y] : sample_pixels(plan.description().film, grid, grid))
        starts.push_back(camera_ray_start(plan, x, y));
    std::vector<RayEnd> ends;
    return trace(plan, starts, ends);
}

}  // namespace kagero
