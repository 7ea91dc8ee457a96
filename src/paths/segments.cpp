#include "paths/segments.h"

#include <array>
#include <numeric>

namespace kagero {

void Segments::group_by_octant() {
    const auto octant_of = [](const RayStart& start) {
        return std::size_t{start.p[0] > 0} | std::size_t{start.p[1] > 0} << 1 | std::size_t{start.p[2] > 0} << 2;
    };
    std::array<std::size_t, 9> begins{};  // of each octant
    for (const RayStart& start : list.starts) ++begins[octant_of(start) + 1];
    std::partial_sum(begins.begin(), begins.end(), begins.begin());
    grouped_rays_.resize(rays.size());
    grouped_starts_.resize(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const std::size_t place = begins[octant_of(list.starts[i])]++;
        grouped_rays_[place] = rays[i];
        grouped_starts_[place] = list.starts[i];
    }
    rays.swap(grouped_rays_);
    list.starts.swap(grouped_starts_);
}

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

PathPoints::PathPoints(const Plan& plan, const Job& job, const std::vector<RayEnd>& ends,
                       const std::vector<PathState>& paths, const std::vector<std::uint32_t>& segments,
                       std::uint64_t first_ray, bool adds_action_to_time)
    : plan_(plan), job_(job), ends_(ends), paths_(paths), segments_(segments), first_ray_(first_ray),
      adds_action_to_time_(adds_action_to_time) {}

void PathPoints::install(Job& job_of_segments) {
    if (!job_.path_sink) return;
    for (const std::uint32_t ray : segments_) offsets_.push_back(ends_[ray].parameter);
    job_of_segments.path_sink = receive;
    job_of_segments.path_user = this;
    job_of_segments.path_interval = job_.path_interval;
    job_of_segments.path_offsets = offsets_.data();
}

void PathPoints::receive(void* user, const PathPoint* point) { static_cast<const PathPoints*>(user)->pass_on(*point); }

void PathPoints::pass_on(PathPoint point) const {
    const std::uint32_t ray = segments_[static_cast<std::size_t>(point.ray)];
    const RayEnd& before = ends_[ray];
    const PathState& path = paths_[ray];
    const bool at_even_intervals = job_.path_interval > 0;
    if (at_even_intervals && point.step == 0 && path.bounces > 0) return;  // the start of a segment is no such point
    point.ray = first_ray_ + ray;
    if (at_even_intervals) {
        point.parameter = point.step * job_.path_interval;
    } else {
        point.step += before.steps;
        point.parameter += before.parameter;
    }
    point.time = before.time + (adds_action_to_time_ ? -point.action : point.time);
    point.action += before.action;
    point.segment = path.bounces;
    point.medium = path.medium;
    to_space(plan_, point.medium, point.q);
    job_.path_sink(job_.path_user, &point);
}

}  // namespace kagero
