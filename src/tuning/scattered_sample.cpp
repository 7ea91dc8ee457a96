#include "tuning/scattered_sample.h"

#include "geometry/shapes.h"
#include "paths/interaction.h"
#include "scene/vector3.h"

namespace kagero {
namespace {

/// Adds the ray that a diffuse surface scatters, and its neighbours. The ray belongs to the same pixel as the ray that
/// has hit the surface.
void add_scattered_ray(const Plan& plan, const DiffusePoint& point, std::size_t ray, SurfaceFrames& frames,
                       Scatterer& scatterer, SampleRays& sample) {
    const SurfaceFrame& frame = frames.at({&point, 1})[0];
    if (!frame.exists()) return;
    const PixelRay member{static_cast<std::uint32_t>(ray), 0, 0, plan.description().film.seed};
    const Double3 d = scatterer.scatter(point, frame, member, PathState{}).direction;
    const auto [e1, e2] = axes_around(d);
    if (!(dot(d, frame.normal()) > 2 * sample.neighbour_angle)) return;
    sample.starts.push_back(frame.start_along(d));
    sample.right.push_back(frame.start_along(unit(add(d, scaled(e1, sample.neighbour_angle)))));
    sample.below.push_back(frame.start_along(unit(add(d, scaled(e2, sample.neighbour_angle)))));
    const std::array<double, 2> pixel = sample.pixels[ray];
    sample.pixels.push_back(pixel);
}

}  // namespace

void add_scattered_rays(const Plan& plan, const RunControl& control, SampleRays& sample) {
    InteractionSolver solver(plan);
    SurfaceFrames frames(plan);
    Scatterer scatterer(plan);
    std::vector<RayEnd> ends;
    std::vector<PathState> paths;
    trace(plan, sample.starts, ends, control, &paths);
    for (std::size_t i = 0; i < ends.size(); ++i) {
        if (ends[i].status != Status::hit || (!paths.empty() && paths[i].medium != 0) ||
            plan.description().objects[ends[i].surface].material != Material::diffuse)
            continue;
        const RayEnd end = to_hamiltonian_coordinates(plan, ends[i]);
        const Double3 start{sample.starts[i].q[0], sample.starts[i].q[1], sample.starts[i].q[2]};
        const RayAtSurface hit{0, &end, start};
        const std::optional<DiffusePoint> point = solver.solve({&hit, 1}).front().diffuse;
        if (point) add_scattered_ray(plan, *point, i, frames, scatterer, sample);
    }
}

}  // namespace kagero
