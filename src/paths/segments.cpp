#include "paths/segments.h"

namespace kagero {

void to_space(const Plan& plan, std::uint32_t medium, double (&q)[3]) {
    if (medium == 0) return;
    const Double3 &from = plan.medium(medium).description().space.center, &to = plan.description().space.center;
    for (std::size_t k = 0; k < 3; ++k) q[k] += from[k] - to[k];
}

void append(const RayEnd& path, RayEnd& segment, bool has_integrals) {
    segment.steps += path.steps;
    segment.gradients += path.gradients;
    segment.iterations += path.iterations;
    segment.queries += path.queries;
    segment.parameter += path.parameter;
    if (has_integrals) {
        segment.action += path.action;
        segment.time += path.time;
    }
    segment.unrefined = segment.unrefined || path.unrefined;
    if (!(segment.energy_error > path.energy_error)) segment.energy_error = path.energy_error;
}

void PathPoints::receive(void* user, const PathPoint* point) {
    const PathPoints& self = *static_cast<PathPoints*>(user);
    const std::uint32_t ray = self.segments[static_cast<std::size_t>(point->ray)];
    const RayEnd& before = self.ends[ray];
    PathPoint shifted = *point;
    shifted.ray = self.first_ray + ray;
    shifted.step += before.steps;
    shifted.parameter += before.parameter;
    shifted.action += before.action;
    shifted.time += before.time;
    shifted.segment = self.paths[ray].bounces;
    shifted.medium = self.paths[ray].medium;
    to_space(self.plan, shifted.medium, shifted.q);
    self.job.path_sink(self.job.path_user, &shifted);
}

}  // namespace kagero
