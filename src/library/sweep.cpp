#include "library/sweep.h"

#include "error.h"
#include "library/ray_arrays.h"
#include "plan/names.h"
#include "sweep/unread_keys.h"

#include <chrono>

namespace kagero {
namespace {

/// Returns the control of one of several runs, whose progress is its share of the progress of all.
RunControl control_of_set(const RunControl& control, std::size_t set, std::size_t sets) {
    RunControl part = control;
    if (control.progress)
        part.progress = [&control, set, sets](double done, double seconds) {
            control.progress((double(set) + done) / double(sets), seconds);
        };
    return part;
}

/// Returns the report on the ends of rays.
RunReport report_on(const SweepResult& result, double seconds) {
    RunReport report;
    report.rays = result.ends.size();
    report.seconds = seconds;
    report.interrupted = result.interrupted;
    std::vector<double> energy_errors;
    for (const RayEnd& end : result.ends) {
        ++report.counters.ended[static_cast<int>(end.status)];
        ++report.failures[static_cast<std::size_t>(end.failure)];
        if (result.plan.run.outputs & output_energy) energy_errors.push_back(end.energy_error);
    }
    report.energy_error = percentiles_of(std::move(energy_errors));
    return report;
}

}  // namespace

std::pair<SweepResult, RunReport> sweep_numbers(const ScenePlans& scene, const std::vector<SweptKey>& keys,
                                                const RayArrays& rays, const RayRequest& request,
                                                const RunOptions& options, const RunControl& control) {
    std::optional<ObserverKind> observer;
    if (!request.observer.empty()) observer = observer_named(request.observer);
    std::vector<RayInput> inputs;
    for (std::size_t i = 0; i < rays.count; ++i) inputs.push_back(rays[i]);
    const auto plan_with = [&](const std::vector<std::string>& overrides) {
        SceneSource source = scene.source();
        source.overrides.insert(source.overrides.end(), overrides.begin(), overrides.end());
        return *ScenePlans(std::move(source)).rays(options, request);
    };
    const auto begin = std::chrono::steady_clock::now();
    SweepResult result = sweep(plan_with, keys, inputs, observer, control);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    RunReport report = report_on(result, elapsed.count());
    return {std::move(result), std::move(report)};
}

std::vector<SweptSet> trace_sweep(const ScenePlans& scene, const std::vector<std::vector<std::string>>& sets,
                                  const RayArrays& rays, const RayRequest& request, const RunOptions& options,
                                  const RunControl& control) {
    std::optional<ObserverKind> observer;
    if (!request.observer.empty()) observer = observer_named(request.observer);
    std::vector<SweptSet> swept;
    for (const std::vector<std::string>& set : sets) {
        SceneSource source = scene.source();
        source.overrides.insert(source.overrides.end(), set.begin(), set.end());
        SweptSet& added = swept.emplace_back();
        added.plan = ScenePlans(std::move(source)).rays(options, request);
        added.remarks = remarks_on_unread_keys(*added.plan, set);
        if (control.stop && *control.stop) throw Interrupted();
    }
    for (std::size_t i = 0; i < swept.size(); ++i) {
        SweptSet& set = swept[i];
        std::vector<PathState>* paths = request.bounces.value_or(0) > 0 ? &set.paths : nullptr;
        set.report = trace(*set.plan, start_arrays(*set.plan, rays, observer), set.ends,
                           control_of_set(control, i, swept.size()), paths);
        if (!set.report.interrupted) continue;
        swept.resize(i + 1);
        break;
    }
    return swept;
}

}  // namespace kagero
