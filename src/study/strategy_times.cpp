#include "study/strategy_times.h"

#include "modules/modules.h"
#include "render/trace.h"

#include <algorithm>

namespace kagero {
namespace {

/// Every kernel runs once per round. There are between `min_timing_rounds` and `max_timing_rounds` rounds.
constexpr unsigned min_timing_rounds = 3, max_timing_rounds = 25;
/// The measurement ends when all runs together have taken more than this number of seconds times the number of
/// instruction sets, but not before `min_timing_rounds` rounds.
constexpr double seconds_per_isa = 1;

/// A kernel with its plan and the times of its runs.
struct TimedKernel {
    StrategyTime result;
    Plan plan;                  ///< Plan with which the rays are traced by this kernel.
    std::vector<double> times;  ///< Nanoseconds per ray, one per run.
};

/// Returns true if two kernels have the same strategy, form and precision.
bool have_same_kind(const KernelInfo& a, const KernelInfo& b) {
    return a.strategy == b.strategy && a.form == b.form && a.precision == b.precision;
}

/// Appends one kernel per strategy, form and precision, with the instruction set of `isa_plan` and the method and step
/// of `scene_plan`: the first kernel of the module that supports the method. Gangs are left out, because `render` uses
/// a gang only if the scene states the number of lanes of the gang.
void append_kernels(std::vector<TimedKernel>& kernels, const Plan& isa_plan, const Plan& scene_plan) {
    const Module& module = isa_plan.module();
    const std::size_t first_of_isa = kernels.size();
    for (std::uint32_t i = 0; i < module.kernel_count; ++i) {
        const KernelInfo& kernel = module.kernels[i];
        if (kernel.form == Form::gang) continue;
        const bool already_added =
            std::any_of(kernels.begin() + std::ptrdiff_t(first_of_isa), kernels.end(),
                        [&](const TimedKernel& timed) { return have_same_kind(*timed.result.kernel, kernel); });
        if (already_added) continue;
        auto variant = find_variant(isa_plan, scene_plan.method().name, kernel, 0);  // The step is set below.
        if (!variant) continue;
        variant->step = info_of(isa_plan, *variant).adaptive ? scene_plan.run.tolerance : scene_plan.run.step;
        kernels.push_back({{module.isa, &kernel, {}}, plan_with_variant(isa_plan, *variant), {}});
    }
}

}  // namespace

std::vector<StrategyTime> strategy_times(const Plan& plan, const std::vector<RayStart>& rays, unsigned threads,
                                         const std::atomic<bool>* stop) {
    std::vector<TimedKernel> kernels;
    const std::string& requested = plan.run.kernel_request.isa;
    const std::vector<std::string> isas = find_isa_names(requested == "auto" ? "all" : requested);
    for (const std::string& isa : isas) {
        SceneDescription description = plan.description();
        description.integrator.lanes = 0;  // This instruction set may have no kernel with the scene's number of lanes.
        Plan isa_plan = rebuild_plan(plan, std::move(description), isa);
        isa_plan.run.threads = threads;
        append_kernels(kernels, isa_plan, plan);
    }
    const auto stopped = [stop] { return stop && stop->load(std::memory_order_relaxed); };
    std::vector<RayEnd> ends;
    double total_seconds = 0;
    for (unsigned round = 0; round < max_timing_rounds; ++round) {
        if (round >= min_timing_rounds && total_seconds > seconds_per_isa * double(isas.size())) break;
        for (TimedKernel& timed : kernels) {
            if (stopped()) break;
            const RunReport report = trace(timed.plan, rays, ends, {.stop = stop});
            if (report.interrupted) break;
            timed.times.push_back(1e9 * report.seconds / double(rays.size()));
            total_seconds += report.seconds;
        }
    }
    std::vector<StrategyTime> results;
    for (TimedKernel& timed : kernels) {
        timed.result.time = timing_of(std::move(timed.times));
        results.push_back(std::move(timed.result));
    }
    return results;
}

}  // namespace kagero
