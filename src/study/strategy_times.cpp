#include "study/strategy_times.h"

#include "modules/modules.h"
#include "render/trace.h"

#include <algorithm>

namespace kagero {
namespace {

constexpr unsigned least_rounds = 3, most_rounds = 25;
/// More rounds than the least are run until this time has been spent on each instruction set.
constexpr double enough_seconds = 1;

struct TimedKernel {
    StrategyTime result;
    Plan plan;  ///< by that kernel
    std::vector<double> times;
};

bool alike(const KernelInfo& a, const KernelInfo& b) {
    return a.strategy == b.strategy && a.form == b.form && a.precision == b.precision;
}

/// The first kernel of each strategy, form and precision that serves the scene, as `render` would take it.
void add_runners(std::vector<TimedKernel>& runners, const Plan& plan, const Plan& like) {
    const std::size_t before = runners.size();
    for (std::uint32_t i = 0; i < plan.module().kernel_count; ++i) {
        const KernelInfo& kernel = plan.module().kernels[i];
        if (kernel.form == Form::gang) continue;
        const bool taken = std::any_of(runners.begin() + std::ptrdiff_t(before), runners.end(),
                                       [&](const TimedKernel& runner) { return alike(*runner.result.kernel, kernel); });
        if (taken) continue;
        auto variant = find_variant(plan, like.method().name, kernel, 0);
        if (!variant) continue;
        variant->step = info_of(plan, *variant).adaptive ? like.run.tolerance : like.run.step;
        runners.push_back({{plan.module().isa, &kernel, {}}, plan_by(plan, *variant), {}});
    }
}

}  // namespace

std::vector<StrategyTime> strategy_times(const Plan& plan, const std::vector<RayStart>& rays, unsigned threads,
                                         const std::atomic<bool>* stop) {
    std::vector<TimedKernel> runners;
    const std::string& wished = plan.run.wish.isa;
    const std::vector<std::string> isas = isas_for(wished == "auto" ? "all" : wished);
    for (const std::string& isa : isas) {
        SceneDescription description = plan.description();
        description.integrator.lanes = 0;  // not every instruction set has packets of them
        Plan one = remade(plan, std::move(description), isa);
        one.run.threads = threads;
        add_runners(runners, one, plan);
    }
    const auto stopped = [stop] { return stop && stop->load(std::memory_order_relaxed); };
    std::vector<RayEnd> ends;
    double spent = 0;
    for (unsigned round = 0; round < most_rounds; ++round) {
        if (round >= least_rounds && spent > enough_seconds * double(isas.size())) break;
        for (TimedKernel& runner : runners) {
            if (stopped()) break;
            const RunReport report = trace(runner.plan, rays, ends, {.stop = stop});
            if (report.interrupted) break;
            runner.times.push_back(1e9 * report.seconds / double(rays.size()));
            spent += report.seconds;
        }
    }
    std::vector<StrategyTime> results;
    for (TimedKernel& runner : runners) {
        runner.result.time = timing_of(std::move(runner.times));
        results.push_back(std::move(runner.result));
    }
    return results;
}

}  // namespace kagero
