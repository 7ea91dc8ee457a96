#include "rays/camera.h"
#include "rays/coherence.h"
#include "plan/formula_space.h"
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
    for (std::uint32_t i = 0; i < rays; i += chunk) work.tiles.push_back({i, 0, std::min(i + chunk, static_cast<std::uint32_t>(rays)), 1});
    return work;
}

/// To the scene's coordinates and unit of length, which λ has too. `Point` is RayEnd or PathPoint.
template <class Point>
void to_scene(const Plan& plan, Point& point) {
    for (std::size_t k = 0; k < 3; ++k) point.q[k] = (point.q[k] + plan.scene.space.center[k]) * plan.unit;
    point.parameter *= plan.unit;
}

/// Whether finished lanes are to get new rays: where some packets of the list say that lanes stand empty, and for long enough to be worth
/// the start of a packet.
bool refill_pays(const Plan& plan, const Job& job, std::size_t rays) {
    constexpr double full = 0.75, short_of_steps = 20;
    constexpr std::uint32_t packets = 16;
    const std::uint32_t lanes = plan.kernel->lanes, probed = packets * lanes;
    if (lanes == 1 || rays < 32 * std::size_t{probed}) return false;
    Counters counters{};
    std::vector<RayEnd> ends;
    for (std::uint32_t i = 0; i < packets; ++i) {
        const auto first = static_cast<std::uint32_t>(i * (rays / packets)) / lanes * lanes;  // a packet begins there
        const Tile tile{first, 0, first + lanes, 1};
        trace_tile(*plan.kernel, job, tile, {}, ends, counters);
    }
    const double steps = double(counters.active_lane_steps) / probed;
    return steps > short_of_steps && double(counters.active_lane_steps) < full * double(counters.issued_lane_steps);
}

/// A list in the order in which it is traced; no ray's end depends on it.
class OrderedList {
public:
    OrderedList(const Plan& plan, const std::vector<RayStart>& starts) {
        const auto begin = std::chrono::steady_clock::now();
        if (starts.size() > plan.kernel->lanes && plan.kernel->lanes > 1 && !neighbours_go_together(starts)) {
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
    job.parameter_limit /= plan.unit;
    if (plan.options.parameter) job.outputs |= output_parameter;
    const bool ends_at_rounded = plan.kernel->precision == Precision::float32 && std::isfinite(job.parameter_limit);
    const auto begin = std::chrono::steady_clock::now();
    if (plan.scene.integrator.refill == "auto") job.refill = !job.path_sink && refill_pays(plan, job, starts.size());
    const double probed = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    ends.resize(starts.size());
    const WorkList work = cut_list(starts.size());
    std::vector<char> traced(work.tiles.size());
    const auto take = [&](const Tile& tile, const RayEnd* done, const RayList&, const Halt&) {
        for (std::uint32_t i = tile.x0; i < tile.x1; ++i) {
            if (i + prefetched < tile.x1) __builtin_prefetch(&ends[list.place(i + prefetched)], 1);
            RayEnd& end = ends[list.place(i)] = done[i - tile.x0];
            const bool went = end.failure == Failure::none || (starts[i].failure == Failure::none && end.failure != Failure::singular_start);
            if (!went) end = end_at_start(starts[i], end.failure);
            if (ends_at_rounded && end.status == Status::step_limit && end.parameter == float(job.parameter_limit)) end.parameter = job.parameter_limit;
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

/// Squares of lengths beyond this leave the numbers of the kernel.
double greatest_length(const Plan& plan) {
    return plan.kernel->precision == Precision::float32 ? 1e18 : 1e150;
}

/// The state of a ray with dq/dλ along d. Rays that start farther out than H can be evaluated, and move on outward, have escaped.
RayStart directed(const Plan& plan, const double (&q)[3], const Double3& d) {
    const double distance = std::hypot(q[0], q[1], q[2]), limit = greatest_length(plan);
    const bool outward = q[0] / distance * d[0] + q[1] / distance * d[1] + q[2] / distance * d[2] > 0;
    const bool far = distance > limit && distance > plan.job.escape_radius && outward && std::isfinite(distance);
    const double shrink = far ? limit / distance : 1;
    const double near[3] = {shrink * q[0], shrink * q[1], shrink * q[2]};
    RayStart start{};
    plan.module->start(plan.hamiltonian, plan.parameters.data(), near, d.data(), &start);
    start.escaped = far && start.failure == Failure::none;
    std::copy(q, q + 3, start.q);
    return start;
}

/// The rest frame of an observer; asked for anew only where the place is another.
class ObserverFrame {
public:
    ObserverFrame(const Plan& plan, ObserverKind of) : kind(of), plan_(plan) {}

    Failure go_to(const double (&q)[3]) {
        if (!std::equal(q, q + 3, place_)) {
            failure_ = observe(plan_, kind, q, map);
            std::copy(q, q + 3, place_);
        }
        return failure_;
    }

    const ObserverKind kind;
    StartMap map;  ///< of the place gone to last

private:
    static constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();
    const Plan& plan_;
    double place_[3] = {nowhere, nowhere, nowhere};
    Failure failure_ = Failure::none;
};

/// Whether the space is another one where time runs the other way.
bool spins(const Plan& plan) {
    const HamiltonianInfo& info = plan.module->hamiltonians[plan.hamiltonian];
    for (std::uint32_t i = 0; i < info.parameter_count; ++i)
        if (info.parameters[i].odd && plan.parameters[i] != 0) return true;
    return false;
}

/// The state of a ray whose direction is read in an observer's rest frame.
RayStart observed(const Plan& plan, ObserverFrame& frame, const double (&q)[3], Double3 d) {
    RayStart start{{q[0], q[1], q[2]}, {0, 0, 0}, 0, Failure::none, false, false};
    const double size = std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])});
    if (!std::isfinite(q[0] + q[1] + q[2]) || !std::isfinite(d[0]) || !std::isfinite(d[1]) || !std::isfinite(d[2])) return start.failure = Failure::nonfinite_start, start;
    if (!(size > 0)) return start.failure = Failure::zero_direction, start;
    for (double& component : d) component /= size;  // its length does not matter, however large or small
    start.failure = frame.go_to(q);
    if (start.failure == Failure::no_rest_frame) return formula_ray(plan, q, d);
    return start.failure == Failure::none ? ray_in_frame(frame.map, q, d).start : start;
}

}  // namespace

std::vector<RayStart> start_rays(const Plan& plan, const std::vector<RayInput>& rays, const std::string& observer) {
    std::vector<RayStart> starts;
    starts.reserve(rays.size());
    std::optional<ObserverFrame> frame;
    if (!observer.empty()) frame.emplace(plan, observer_named(observer));
    if (observer == "falling" && plan.time > 0 && spins(plan)) throw RunError("the plan was not made for rays of a falling observer (Options::observer)");
    for (const RayInput& ray : rays) {
        double q[3];
        for (int k = 0; k < 3; ++k) q[k] = ray.position[k] / plan.unit - plan.scene.space.center[k];
        starts.push_back(frame ? observed(plan, *frame, q, ray.direction) : directed(plan, q, ray.direction));
    }
    for (RayStart& start : starts)
        if ((start.failure == Failure::none || start.failure == Failure::singular_start) && !start.escaped &&
            std::hypot(start.q[0], start.q[1], start.q[2]) > greatest_length(plan)) start.failure = Failure::too_far;
        else if (start.failure == Failure::none && lacks_pace(plan, start.q)) start.failure = Failure::no_pace;
        else if (start.failure == Failure::none && lacks_bounds(plan, start.q)) start.failure = Failure::no_bounds;
        else if (start.failure == Failure::none && !start.captured && observer != "falling" && start.pt > 0 &&  // which may vanish
            needs_double(plan, std::hypot(start.p[0], start.p[1], start.p[2]) / std::abs(start.pt)))
            start.failure = Failure::needs_double;
    return starts;
}

RunReport trace(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends, const Watch& watch) {
    Job job = plan.job;
    return run_list(plan, job, OrderedList(plan, starts), ends, watch);
}

std::vector<PathPoint> trace_paths(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends, const Watch& watch) {
    struct Collector {
        std::mutex mutex;
        std::vector<PathPoint> points;
    } collector;
    Job job = plan.job;
    job.path_user = &collector;
    job.path_sink = [](void* user, const PathPoint* point) {
        auto& c = *static_cast<Collector*>(user);
        const std::lock_guard lock(c.mutex);
        c.points.push_back(*point);
    };
    const OrderedList list(plan, starts);
    run_list(plan, job, list, ends, watch);
    for (PathPoint& point : collector.points) {
        to_scene(plan, point);
        point.ray = list.place(point.ray);
    }
    // Of rays that were given up no path is left either.
    std::erase_if(collector.points, [&](const PathPoint& point) { return ends[point.ray].failure == Failure::untraced; });
    std::stable_sort(collector.points.begin(), collector.points.end(), [](const PathPoint& a, const PathPoint& b) {
        return a.ray != b.ray ? a.ray < b.ray : a.step < b.step;
    });
    return std::move(collector.points);
}

RayStart pixel_ray(const Plan& plan, std::uint32_t x, std::uint32_t y) {
    return film_ray(plan, x + 0.5, y + 0.5);
}

RayStart film_ray(const Plan& plan, double x, double y) {
    return camera_ray(plan, x, y).start;
}

}  // namespace kagero
