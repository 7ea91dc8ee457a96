#include "render/trace.h"

#include "rays/coherence.h"
#include "render/run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <mutex>
#include <optional>

namespace kagero {
namespace {

/// Rays of a list handed out at a time: a few packets of any width.
constexpr std::uint32_t chunk = 256;
/// How many rays ahead memory is asked for where they lie in no order.
constexpr std::uint32_t prefetched = 8;

WorkList cut_list(std::size_t rays) {
    WorkList work;
    for (std::uint32_t i = 0; i < rays; i += chunk)
        work.tiles.push_back({i, 0, std::min(i + chunk, static_cast<std::uint32_t>(rays)), 1});
    return work;
}

/// To the scene's coordinates and unit of length, which λ has too. `Point` is RayEnd or PathPoint.
template <class Point>
void to_scene(const Plan& plan, Point& point) {
    for (std::size_t k = 0; k < 3; ++k)
        point.q[k] = (point.q[k] + plan.description().space.center[k]) * plan.scene->unit;
    point.parameter *= plan.scene->unit;
}

/// Whether finished lanes are to get new rays: where some packets of the list say that lanes stand empty, and for long
/// enough to be worth the start of a packet.
bool refill_pays(const Plan& plan, const Job& job, std::size_t rays) {
    constexpr double full = 0.75, short_of_steps = 20;
    constexpr std::uint32_t packets = 16;
    const std::uint32_t lanes = plan.run.kernel->lanes, probed = packets * lanes;
    if (lanes == 1 || rays < 32 * std::size_t{probed}) return false;
    Counters counters{};
    std::vector<RayEnd> ends;
    for (std::uint32_t i = 0; i < packets; ++i) {
        const auto first = static_cast<std::uint32_t>(i * (rays / packets)) / lanes * lanes;  // a packet begins there
        const Tile tile{first, 0, first + lanes, 1};
        trace_tile(*plan.run.kernel, job, tile, {}, ends, counters);
    }
    const double steps = double(counters.active_lane_steps) / probed;
    return steps > short_of_steps && double(counters.active_lane_steps) < full * double(counters.issued_lane_steps);
}

/// A list in the order in which it is traced; no ray's end depends on it.
class OrderedList {
public:
    OrderedList(const Plan& plan, const std::vector<RayStart>& starts) {
        const auto begin = std::chrono::steady_clock::now();
        if (starts.size() > plan.run.kernel->lanes && plan.run.kernel->lanes > 1 && !neighbours_go_together(starts)) {
            order_ = coherent_order(starts);
            starts_.reserve(starts.size());
            for (std::size_t i = 0; i < order_.size(); ++i) {
                __builtin_prefetch(&starts[order_[std::min(i + prefetched, order_.size() - 1)]]);
                starts_.push_back(starts[order_[i]]);
            }
        }
        rays = order_.empty() ? &starts : &starts_;
        seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    }
    /// Which ray of the list as it was given comes i-th.
    std::size_t place(std::size_t i) const { return order_.empty() ? i : order_[i]; }

    const std::vector<RayStart>* rays;
    double seconds;  ///< that it took to put it in order

private:
    std::vector<std::uint32_t> order_;
    std::vector<RayStart> starts_;
};

/// The end of a ray that never went: where it was to start, without direction or momentum.
RayEnd end_at_start(const RayStart& start, Failure failure) {
    RayEnd end{};
    std::copy_n(start.q, 3, end.q);
    end.energy_error = std::numeric_limits<double>::quiet_NaN();
    end.status = Status::failed, end.failure = failure;
    return end;
}

/// Ends of rays that an interrupt leaves out say so.
RunReport run_list(const Plan& plan, Job& job, const OrderedList& list, std::vector<RayEnd>& ends, const Watch& watch) {
    const std::vector<RayStart>& starts = *list.rays;
    job.camera = nullptr;
    job.rays = starts.data();
    job.parameter_limit /= plan.scene->unit;
    const bool ends_at_rounded = plan.run.kernel->precision == Precision::float32 && std::isfinite(job.parameter_limit);
    const auto begin = std::chrono::steady_clock::now();
    if (plan.run.refill == Refill::automatic) job.refill = !job.path_sink && refill_pays(plan, job, starts.size());
    const double probed = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    ends.resize(starts.size());
    const WorkList work = cut_list(starts.size());
    std::vector<char> traced(work.tiles.size());
    const auto take = [&](const Tile& tile, const RayEnd* done, const RayList&, const Halt&) {
        for (std::uint32_t i = tile.x0; i < tile.x1; ++i) {
            if (i + prefetched < tile.x1) __builtin_prefetch(&ends[list.place(i + prefetched)], 1);
            RayEnd& end = ends[list.place(i)] = done[i - tile.x0];
            const bool went = end.failure == Failure::none ||
                              (starts[i].failure == Failure::none && end.failure != Failure::singular_start);
            if (!went) end = end_at_start(starts[i], end.failure);
            if (ends_at_rounded && end.status == Status::step_limit && end.parameter == float(job.parameter_limit))
                end.parameter = job.parameter_limit;
            to_scene(plan, end);
        }
        traced[tile.x0 / chunk] = true;
    };
    RunReport report = run_tiles(plan, job, work, {}, take, watch);
    for (std::size_t i = 0; report.interrupted && i < starts.size(); ++i)
        if (!traced[i / chunk]) to_scene(plan, ends[list.place(i)] = end_at_start(starts[i], Failure::untraced));
    report.seconds += list.seconds + probed;
    return report;
}

}  // namespace

RunReport trace(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends, const Watch& watch) {
    Job job = plan.job();
    return run_list(plan, job, OrderedList(plan, starts), ends, watch);
}

RunReport trace_steps(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends,
                      const std::function<void(const PathPoint&)>& visit, const Watch& watch) {
    const OrderedList list(plan, starts);
    struct Visitor {
        const OrderedList& list;
        const std::function<void(const PathPoint&)>& visit;
        std::mutex mutex{};
    } visitor{list, visit};
    Job job = plan.job();
    job.path_user = &visitor;
    job.path_sink = [](void* user, const PathPoint* point) {
        auto& v = *static_cast<Visitor*>(user);
        PathPoint listed = *point;
        listed.ray = v.list.place(point->ray);
        const std::lock_guard lock(v.mutex);
        v.visit(listed);
    };
    return run_list(plan, job, list, ends, watch);
}

std::vector<PathPoint> trace_paths(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends,
                                   const Watch& watch) {
    std::vector<PathPoint> points;
    trace_steps(plan, starts, ends, [&](const PathPoint& point) { points.push_back(point); }, watch);
    for (PathPoint& point : points) to_scene(plan, point);
    // Of rays that were given up no path is left either.
    std::erase_if(points, [&](const PathPoint& point) { return ends[point.ray].failure == Failure::untraced; });
    std::stable_sort(points.begin(), points.end(), [](const PathPoint& a, const PathPoint& b) {
        return a.ray != b.ray ? a.ray < b.ray : a.step < b.step;
    });
    return points;
}

}  // namespace kagero
