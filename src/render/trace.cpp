#include "render/trace.h"

#include "error.h"
#include "large_vector.h"
#include "rays/coherence.h"
#include "rays/ray_ends.h"
#include "render/run.h"
#include "scene/value.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <mutex>
#include <optional>

namespace kagero {
namespace {

/// Number of rays of a list in one tile of the WorkList: at least a few packets.
constexpr std::uint32_t rays_per_chunk = 256;
/// Number of rays between a prefetch and the access, in a list that is accessed in scattered order.
constexpr std::uint32_t prefetch_distance = 8;

WorkList split_into_chunks(std::size_t rays) {
    WorkList work;
    for (std::uint32_t i = 0; i < rays; i += rays_per_chunk)
        work.tiles.push_back({i, 0, std::min(i + rays_per_chunk, static_cast<std::uint32_t>(rays)), 1});
    return work;
}

/// Returns true if refill is worthwhile, from a trial of a few packets of the list. Their occupancy must be low, and
/// their rays must take enough steps to outweigh the cost of a refill.
bool is_refill_worthwhile(const Plan& plan, const Job& job, std::size_t rays) {
    constexpr double max_occupancy = 0.75, min_steps = 20;
    constexpr std::uint32_t packets = 16;
    const std::uint32_t lanes = plan.run.kernel->lanes;
    const std::uint32_t trial_rays = packets * lanes;
    if (lanes == 1 || rays < 32 * std::size_t{trial_rays}) return false;  // The trial would cost too much.
    Counters counters{};
    std::vector<RayEnd> ends;
    for (std::uint32_t i = 0; i < packets; ++i) {
        const auto first_ray = static_cast<std::uint32_t>(i * (rays / packets)) / lanes * lanes;
        const Tile tile{first_ray, 0, first_ray + lanes, 1};
        trace_tile(*plan.run.kernel, job, tile, {}, ends, counters);
    }
    const double steps = double(counters.active_lane_steps) / trial_rays;
    return steps > min_steps && double(counters.active_lane_steps) < max_occupancy * double(counters.issued_lane_steps);
}

/// A list of rays in the order in which they are traced. No ray's end depends on the order.
class OrderedList {
public:
    OrderedList(const Plan& plan, const std::vector<RayStart>& starts) {
        const auto begin = std::chrono::steady_clock::now();
        if (starts.size() > plan.run.kernel->lanes && plan.run.kernel->lanes > 1 && !neighbours_are_coherent(starts)) {
            order_ = coherent_order(starts);
            starts_.reserve(starts.size());
            for (std::size_t i = 0; i < order_.size(); ++i) {
                __builtin_prefetch(&starts[order_[std::min(i + prefetch_distance, order_.size() - 1)]]);
                starts_.push_back(starts[order_[i]]);
            }
        }
        rays = order_.empty() ? &starts : &starts_;
        sort_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    }
    /// Returns the index, in the list of the constructor, of the ray that is traced i-th.
    std::size_t input_index(std::size_t i) const { return order_.empty() ? i : order_[i]; }

    const std::vector<RayStart>* rays;  ///< The ray starts in the order of tracing.
    double sort_seconds;                ///< Time for the sorting.

private:
    std::vector<std::uint32_t> order_;  ///< Input index of each ray; empty if the order is that of the input.
    std::vector<RayStart> starts_;      ///< The sorted ray starts; empty if the order is that of the input.
};

/// Traces the list. If the run is interrupted, rays that were not traced get the failure `untraced`.
RunReport run_list(const Plan& plan, Job& job, const OrderedList& list, std::vector<RayEnd>& ends,
                   const RunControl& control, std::vector<PathState>* paths = nullptr) {
    const std::vector<RayStart>& starts = *list.rays;
    job.camera = nullptr;
    job.rays = starts.data();
    job.parameter_limit /= plan.scene->unit;
    job.path_interval /= plan.scene->unit;
    // A float kernel ends rays where λ equals the limit rounded to float. Their ends get the exact limit.
    const bool rounds_limit = plan.run.kernel->precision == Precision::float32 && std::isfinite(job.parameter_limit);
    const auto begin = std::chrono::steady_clock::now();
    if (plan.run.refill == Refill::automatic)
        job.refill = !job.path_sink && is_refill_worthwhile(plan, job, starts.size());
    const double trial_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (ends.capacity() < starts.size()) ends = large_vector<RayEnd>(starts.size(), plan.run.threads);
    ends.resize(starts.size());
    if (paths) paths->assign(starts.size(), PathState{});
    const WorkList work = split_into_chunks(starts.size());
    std::vector<char> is_traced(work.tiles.size());
    const auto store = [&](const Tile& tile, const TracedRays& traced, const CancelToken&) {
        for (std::uint32_t i = tile.x0; i < tile.x1; ++i) {
            if (i + prefetch_distance < tile.x1) __builtin_prefetch(&ends[list.input_index(i + prefetch_distance)], 1);
            RayEnd& end = ends[list.input_index(i)] = traced.ends[i - tile.x0];
            if (paths && !traced.paths.empty()) (*paths)[list.input_index(i)] = traced.paths[i - tile.x0];
            if (rounds_limit && end.status == Status::step_limit && end.parameter == float(job.parameter_limit))
                end.parameter = job.parameter_limit;
            end = reported_end(*plan.scene, plan.scene->space, starts[i], end);
        }
        is_traced[tile.x0 / rays_per_chunk] = true;
    };
    RunReport report = run_tiles(plan, job, work, {}, store, control);
    for (std::size_t i = 0; report.interrupted && i < starts.size(); ++i)
        if (!is_traced[i / rays_per_chunk])
            to_scene_coordinates(*plan.scene, ends[list.input_index(i)] = end_at_start(starts[i], Failure::untraced));
    report.seconds += list.sort_seconds + trial_seconds;
    return report;
}

}  // namespace

RunReport trace(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends,
                const RunControl& control, std::vector<PathState>* paths) {
    Job job = plan.job();
    return run_list(plan, job, OrderedList(plan, starts), ends, control, paths);
}

namespace {

std::string with_three_digits(double number) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", number);
    return text;
}

}  // namespace

bool check_path_points(Plan plan, const std::vector<RayStart>& starts, std::size_t batch, const RunControl& control) {
    constexpr double max_points = 1e7;  // in memory at the same time
    const double interval = plan.run.path_interval;
    if (!(interval > 0)) return true;
    plan.run.outputs |= output_parameter;
    std::vector<RayEnd> ends;
    if (trace(plan, starts, ends, control).interrupted) return false;
    double most_points = 0;
    for (std::size_t first = 0; first < ends.size(); first += batch) {
        double length = 0;
        for (std::size_t i = first; i < std::min(first + batch, ends.size()); ++i)
            if (std::isfinite(ends[i].parameter)) length += ends[i].parameter;
        most_points = std::max(most_points, length / interval);
    }
    if (most_points <= max_points) return true;
    const std::size_t paths = std::min(batch, ends.size());
    throw InputError("the interval " + to_toml(interval) +
                     " of λ between the points of paths is too short: " + std::to_string(paths) +
                     (paths == 1 ? " path" : " paths") + " would have " + with_three_digits(most_points) +
                     " points in memory, which must be at most " + with_three_digits(max_points) + "; state at least " +
                     with_three_digits(1.01 * interval * most_points / max_points));
}

RunReport trace_steps(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends,
                      const std::function<void(const PathPoint&)>& visit, const RunControl& control) {
    const OrderedList list(plan, starts);
    struct Visitor {
        const OrderedList& list;
        const std::function<void(const PathPoint&)>& visit;
        std::mutex mutex{};
    } visitor{list, visit};
    Job job = plan.job();
    job.path_user = &visitor;
    job.path_sink = [](void* user, const PathPoint* point) {
        auto& target = *static_cast<Visitor*>(user);
        PathPoint visited = *point;
        visited.ray = target.list.input_index(point->ray);
        const std::lock_guard lock(target.mutex);
        target.visit(visited);
    };
    return run_list(plan, job, list, ends, control);
}

std::vector<PathPoint> trace_paths(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends,
                                   const RunControl& control) {
    std::vector<PathPoint> points;
    trace_steps(
        plan, starts, ends, [&](const PathPoint& point) { points.push_back(point); }, control);
    for (PathPoint& point : points) {
        to_ingoing_form(plan.scene->space, starts[point.ray], point);
        to_scene_coordinates(*plan.scene, point);
    }
    // Removes the paths of rays whose tracing was interrupted.
    std::erase_if(points, [&](const PathPoint& point) { return ends[point.ray].failure == Failure::untraced; });
    std::stable_sort(points.begin(), points.end(), [](const PathPoint& a, const PathPoint& b) {
        return a.ray != b.ray ? a.ray < b.ray : a.step < b.step;
    });
    return points;
}

}  // namespace kagero
