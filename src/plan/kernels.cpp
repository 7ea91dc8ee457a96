#include "plan/kernels.h"

#include "error.h"

#include <algorithm>
#include <span>

namespace kagero {
namespace {

std::span<const KernelInfo> kernels_of(const Module& module) {
    return {module.kernels, module.kernel_count};
}

bool fits(const KernelInfo& kernel, const KernelWish& wish) {
    if (kernel.form == Form::auto_vectorized) return false;  // a yardstick of `compare`, not a way to render
    if (wish.precision && kernel.precision != *wish.precision) return false;
    if (wish.strategy && kernel.strategy != *wish.strategy) return false;
    if (!wish.strategy && kernel.strategy == Strategy::per_ray) return false;
    if (!wish.strategy && wish.lanes == 0 && kernel.strategy != Strategy::packet) return false;
    if (wish.lanes == 0) return kernel.form != Form::gang;
    return kernel.lanes == wish.lanes;
}

/// Whether the widest packets are the quickest: in the plane of an orbit a step is one long chain of a few operations, each of which waits
/// for the one before unless other rays give it something to do (`kagero trace scenes/hole.toml --rays FILE --lanes N --json`).
bool widest_is_best(const Plan& plan) {
    return plan.module->integrators[plan.job.integrator].angular && !plan.job.geometry && !plan.straight;
}

/// "strategy packet, double, integrator.lanes = 64"
std::string text_of(const KernelWish& wish) {
    std::string text;
    if (wish.strategy) enumerate(text, std::string("strategy ") + name_of(*wish.strategy));
    if (wish.precision) enumerate(text, name_of(*wish.precision));
    if (wish.lanes) enumerate(text, "integrator.lanes = " + std::to_string(wish.lanes));
    return text;
}

/// The numbers of lanes that would do, were it not for those that are asked for.
std::string lanes_text(const Plan& plan, KernelWish wish) {
    std::vector<std::uint32_t> lanes;
    for (const KernelInfo& kernel : kernels_of(*plan.module)) {
        wish.lanes = kernel.lanes;
        if (fits(kernel, wish) && !refusal_of(plan, kernel, plan.job.integrator, plan.job.rescaled))
            lanes.push_back(kernel.lanes);
    }
    std::sort(lanes.begin(), lanes.end());
    lanes.erase(std::unique(lanes.begin(), lanes.end()), lanes.end());
    std::string text;
    for (const std::uint32_t n : lanes) enumerate(text, std::to_string(n));
    return text;
}

/// The first that is wished for and serves, or the widest; null where none does, and why not.
const KernelInfo* serving_kernel(const Plan& plan, const KernelWish& wish, std::string& why) {
    const KernelInfo* chosen = nullptr;
    for (const KernelInfo& kernel : kernels_of(*plan.module)) {
        if (!fits(kernel, wish)) continue;
        const char* refusal = refusal_of(plan, kernel, plan.job.integrator, plan.job.rescaled);
        if (refusal) why = refusal;
        else if (!chosen || (widest_is_best(plan) && kernel.strategy == Strategy::packet && kernel.lanes > chosen->lanes)) chosen = &kernel;
    }
    return chosen;
}

}  // namespace

KernelWish wish_of(const Plan& plan) {
    KernelWish wish;
    wish.strategy = strategy_named(plan.options.strategy);
    wish.precision = precision_named(plan.options.precision).value_or(Precision::float64);
    wish.lanes = plan.scene.integrator.lanes;
    return wish;
}

const KernelInfo* find_kernel(const Plan& plan, const KernelWish& wish) {
    std::string why;
    return serving_kernel(plan, wish, why);
}

const KernelInfo& choose_kernel(const Plan& plan, const KernelWish& wish) {
    std::string why;
    if (const KernelInfo* chosen = serving_kernel(plan, wish, why)) return *chosen;
    const std::string there_is_none = text_of(wish) + ": there is no such kernel for " + plan.scene.space.hamiltonian + " by " +
                                      plan.scene.integrator.method + " in the module " + plan.module->isa;
    const Place place = plan.scene.integrator.lanes_place.value_or(Place{});
    if (!why.empty()) throw InputError(place, there_is_none + ": " + why);
    const std::string lanes = lanes_text(plan, wish);
    throw InputError(place, there_is_none + (lanes.empty() ? std::string("; `kagero list strategies` shows those there are")
                                                    : "; lanes there are: " + lanes));
}

const char* refusal_of(const Plan& plan, const KernelInfo& kernel, std::uint32_t integrator, bool rescaled) {
    return kernel.refusal ? kernel.refusal(plan.job.hamiltonian, integrator, rescaled, plan.straight) : nullptr;
}

const char* name_of(Form form) {
    constexpr const char* names[] = {"", "gradient", "stages", "auto-vectorized", "gang"};
    return names[static_cast<int>(form)];
}

}  // namespace kagero
