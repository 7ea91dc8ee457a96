#include "view/pixel_report.h"

#include "accuracy/end_errors.h"
#include "plan/names.h"
#include "rays/list_rays.h"
#include "rays/ray_ends.h"
#include "render/trace.h"

namespace kagero {
namespace {

/// Greatest number of points of a path that are sent.
constexpr std::size_t max_points = 400;

/// Returns at most `max_points` points, evenly selected, with the first and the last one.
Json points_json(const std::vector<PathPoint>& points) {
    Json list = Json::array();
    const std::size_t last = points.empty() ? 0 : points.size() - 1, count = std::min(points.size(), max_points);
    for (std::size_t i = 0; i < count; ++i) {
        const PathPoint& point = points[count == 1 ? 0 : i * last / (count - 1)];
        list.push_back({point.q[0], point.q[1], point.q[2]});
    }
    return list;
}

}  // namespace

Json pixel_json(const Plan& plan, std::uint32_t x, std::uint32_t y) {
    const Tile tile{x, y, x + 1, y + 1};
    TracedRays traced;
    list_rays(plan, tile, traced.list);
    Job job = plan.medium(plan.view.medium).job();
    job.outputs |= output_energy;
    PathCounters counters;
    trace_paths(plan, job, tile, branch_choice_of(plan), traced, counters);
    const EndErrors errors(plan, true, true);
    const EndError error = errors.estimate(tile, traced, {}).at(0);
    std::vector<RayEnd> ends;
    const std::vector<PathPoint> points = trace_paths(plan, {traced.list.starts.at(0)}, ends);
    RayEnd end = traced.ends.at(0);
    to_scene_coordinates(*plan.scene, end);
    return {{"x", x},
            {"y", y},
            {"status", name_of(end.status)},
            {"object", end.status == Status::hit ? plan.description().objects.at(end.surface).name : std::string()},
            {"position", Double3{end.q[0], end.q[1], end.q[2]}},
            {"direction", Double3{end.v[0], end.v[1], end.v[2]}},
            {"steps", end.steps},
            {"gradients", end.gradients},
            {"bounces", traced.paths.empty() ? 0 : traced.paths[0].bounces},
            {"energy_error", end.energy_error},
            {"position_error", error.position},
            {"rounding_error", error.rounding},
            {"path", points_json(points)}};
}

}  // namespace kagero
