#include "sweep/set_by_set.h"

#include "rays/ray_ends.h"
#include "render/threads.h"
#include "render/trace.h"

#include <algorithm>
#include <atomic>
#include <chrono>

namespace kagero {
namespace {

/// Traces the straight rays of one set by one call of the kernel, which takes less time than the start of a run.
void trace_straight_set(const Plan& plan, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends) {
    const Scene& scene = *plan.scene;
    Job job = plan.job();
    job.camera = nullptr;
    job.rays = starts.data();
    job.parameter_limit /= scene.unit;
    job.refill = false;
    Counters counters{};
    trace_tile(*plan.run.kernel, job, {0, 0, static_cast<std::uint32_t>(starts.size()), 1}, {}, ends, counters);
    for (std::size_t i = 0; i < starts.size(); ++i) ends[i] = reported_end(scene, scene.space, starts[i], ends[i]);
}

/// Traces the rays of the selected set. Returns false if the run is interrupted.
bool trace_selected_set(const Plan& plan, const std::vector<RayStart>& starts, const RunControl& control,
                        std::vector<RayEnd>& ends) {
    if (control.stop && control.stop->load(std::memory_order_relaxed)) return false;
    constexpr std::size_t few = 256;
    if (!plan.scene->straight || plan.run.kernel->precision != Precision::float64 || starts.size() > few)
        return !trace(plan, starts, ends, control).interrupted;
    trace_straight_set(plan, starts, ends);
    return true;
}

}  // namespace

bool trace_set_by_set(const Plan& base, const ParameterSets& sets, const std::vector<std::size_t>& traced_sets,
                      const std::vector<RayInput>& rays, std::optional<ObserverKind> observer,
                      const RunControl& control, const EndsOfSets& ends) {
    const auto begin = std::chrono::steady_clock::now();
    // With fewer sets than threads, the rays of a set are divided over the threads.
    const bool divides_sets = traced_sets.size() >= base.run.threads;
    std::atomic<std::size_t> next = 0;
    std::atomic<bool> interrupted = false;
    const auto trace_sets = [&](unsigned thread) {
        SceneOfSets scenes(base, sets, observer);
        if (divides_sets) scenes.plan.run.threads = 1;
        RunControl control_of_set;
        control_of_set.stop = control.stop;
        std::vector<RayEnd> ends_of_set;
        for (std::size_t i = next++; i < traced_sets.size() && !interrupted; i = next++) {
            scenes.select(traced_sets[i]);
            if (!scenes.plan.scene->straight) scenes.plan.run.step = sets.step(base, traced_sets[i]);
            if (!trace_selected_set(scenes.plan, scenes.starts(rays), control_of_set, ends_of_set)) {
                interrupted = true;
                break;
            }
            std::copy(ends_of_set.begin(), ends_of_set.end(), ends.of(traced_sets[i]));
            if (thread == 0 && control.progress)
                control.progress(double(i + 1) / double(traced_sets.size()),
                                 std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
        }
    };
    run_on_threads(divides_sets ? base.run.threads : 1, trace_sets);
    return !interrupted;
}

}  // namespace kagero
