#include "plan/kernels.h"

#include "error.h"
#include "plan/names.h"

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

/// Whether the widest packets are the quickest: in the plane of an orbit a step is one long chain of a few operations,
/// each of which waits for the one before unless other rays give it something to do (`kagero trace scenes/hole.toml
/// --rays FILE --lanes N --json`).
bool widest_is_best(const Scene& scene, const MethodChoice& method) {
    return scene.module().integrators[method.integrator].angular && !scene.geometry->kernel_view() && !scene.straight;
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
std::string lanes_text(const Scene& scene, const MethodChoice& method, KernelWish wish) {
    std::vector<std::uint32_t> lanes;
    for (const KernelInfo& kernel : kernels_of(scene.module())) {
        wish.lanes = kernel.lanes;
        if (fits(kernel, wish) && !refusal_of(scene, kernel, method))
            lanes.push_back(kernel.lanes);
    }
    std::sort(lanes.begin(), lanes.end());
    lanes.erase(std::unique(lanes.begin(), lanes.end()), lanes.end());
    std::string text;
    for (const std::uint32_t n : lanes) enumerate(text, std::to_string(n));
    return text;
}

/// The first that is wished for and serves, or the widest; null where none does, and why not.
const KernelInfo* serving_kernel(const Scene& scene, const MethodChoice& method, const KernelWish& wish,
                                 std::string& why) {
    const KernelInfo* chosen = nullptr;
    for (const KernelInfo& kernel : kernels_of(scene.module())) {
        if (!fits(kernel, wish)) continue;
        const char* refusal = refusal_of(scene, kernel, method);
        if (refusal) why = refusal;
        else if (!chosen ||
                 (widest_is_best(scene, method) && kernel.strategy == Strategy::packet && kernel.lanes > chosen->lanes))
            chosen = &kernel;
    }
    return chosen;
}

}  // namespace

KernelWish wish_of(const Scene& scene, const Options& options) {
    KernelWish wish;
    wish.strategy = options.strategy;
    wish.precision = options.precision;
    wish.isa = options.isa;
    wish.lanes = scene.description.integrator.lanes;
    return wish;
}

const KernelInfo* find_kernel(const Scene& scene, const MethodChoice& method, const KernelWish& wish) {
    std::string why;
    return serving_kernel(scene, method, wish, why);
}

const KernelInfo& choose_kernel(const Scene& scene, const MethodChoice& method, const KernelWish& wish) {
    std::string why;
    if (const KernelInfo* chosen = serving_kernel(scene, method, wish, why)) return *chosen;
    const std::string there_is_none =
        text_of(wish) + ": there is no such kernel for " + scene.description.space.hamiltonian + " by " +
        scene.module().integrators[method.integrator].name + " in the module " + scene.module().isa;
    const Place place = scene.description.integrator.lanes_place.value_or(Place{});
    if (!why.empty()) throw InputError(place, there_is_none + ": " + why);
    const std::string lanes = lanes_text(scene, method, wish);
    throw InputError(place,
                     there_is_none + (lanes.empty() ? std::string("; `kagero list strategies` shows those there are")
                                                    : "; lanes there are: " + lanes));
}

const char* refusal_of(const Scene& scene, const KernelInfo& kernel, const MethodChoice& method) {
    return kernel.refusal
               ? kernel.refusal(scene.integrated_hamiltonian(), method.integrator, method.rescaled, scene.straight)
               : nullptr;
}

}  // namespace kagero
