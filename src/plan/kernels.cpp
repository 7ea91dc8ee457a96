#include "plan/kernels.h"

#include "error.h"
#include "plan/names.h"

#include <algorithm>
#include <span>

namespace kagero {
namespace {

std::span<const KernelInfo> kernels_of(const Module& module) { return {module.kernels, module.kernel_count}; }

/// Returns true if the kernel meets the conditions. Without a requested strategy, per-ray kernels are excluded, and
/// scalar kernels are excluded unless one lane is requested. Gangs are excluded unless their number of lanes is
/// requested. Auto-vectorized kernels are always excluded.
bool meets_request(const KernelInfo& kernel, const KernelRequest& request) {
    if (kernel.form == Form::auto_vectorized) return false;  // Only `compare` uses these kernels.
    if (request.precision && kernel.precision != *request.precision) return false;
    if (request.strategy && kernel.strategy != *request.strategy) return false;
    if (!request.strategy && kernel.strategy == Strategy::per_ray) return false;
    if (!request.strategy && request.lanes == 0 && kernel.strategy != Strategy::packet) return false;
    if (request.lanes == 0) return kernel.form != Form::gang;
    return kernel.lanes == request.lanes;
}

/// Returns true if the widest packets are the fastest: in the orbit plane without surfaces. There, each operation of a
/// step depends on the previous one, and several independent registers per variable hide the latency. Measured with
/// `kagero trace scenes/hole.toml --rays FILE --lanes N --json`.
bool prefers_widest_packets(const Scene& scene, const MethodChoice& method) {
    return scene.module().integrators[method.integrator].angular && !scene.geometry->kernel_view() && !scene.straight;
}

/// Returns the conditions as text, for example "strategy packet, double, integrator.lanes = 64".
std::string text_of(const KernelRequest& request) {
    std::string text;
    if (request.strategy) append_to_list(text, std::string("strategy ") + name_of(*request.strategy));
    if (request.precision) append_to_list(text, name_of(*request.precision));
    if (request.lanes) append_to_list(text, "integrator.lanes = " + std::to_string(request.lanes));
    return text;
}

/// Returns the numbers of lanes, as text, of the kernels that meet all conditions except the requested number of lanes.
std::string available_lanes_text(const Scene& scene, const MethodChoice& method, KernelRequest request) {
    std::vector<std::uint32_t> lanes;
    for (const KernelInfo& kernel : kernels_of(scene.module())) {
        request.lanes = kernel.lanes;
        if (meets_request(kernel, request) && !refusal_of(scene, kernel, method)) lanes.push_back(kernel.lanes);
    }
    std::sort(lanes.begin(), lanes.end());
    lanes.erase(std::unique(lanes.begin(), lanes.end()), lanes.end());
    std::string text;
    for (const std::uint32_t n : lanes) append_to_list(text, std::to_string(n));
    return text;
}

/// Returns the first kernel that meets the conditions and supports scene and method, or the one with the widest packets
/// if these are the fastest. Returns null if there is no such kernel. `reason` receives the last refusal
/// by a kernel that meets the conditions.
const KernelInfo* supporting_kernel(const Scene& scene, const MethodChoice& method, const KernelRequest& request,
                                    std::string& reason) {
    const KernelInfo* chosen = nullptr;
    for (const KernelInfo& kernel : kernels_of(scene.module())) {
        if (!meets_request(kernel, request)) continue;
        const char* refusal = refusal_of(scene, kernel, method);
        if (refusal) reason = refusal;
        else if (!chosen || (prefers_widest_packets(scene, method) && kernel.strategy == Strategy::packet &&
                             kernel.lanes > chosen->lanes))
            chosen = &kernel;
    }
    return chosen;
}

}  // namespace

KernelRequest make_kernel_request(const Scene& scene, const Options& options) {
    KernelRequest request;
    request.strategy = options.strategy;
    request.precision = options.precision;
    request.isa = options.isa;
    request.lanes = scene.description.integrator.lanes;
    return request;
}

const KernelInfo* find_kernel(const Scene& scene, const MethodChoice& method, const KernelRequest& request) {
    std::string reason;
    return supporting_kernel(scene, method, request, reason);
}

const KernelInfo& choose_kernel(const Scene& scene, const MethodChoice& method, const KernelRequest& request) {
    std::string reason;
    if (const KernelInfo* chosen = supporting_kernel(scene, method, request, reason)) return *chosen;
    const std::string message = std::string("the module ") + scene.module().isa + " has no kernel for " +
                                scene.description.space.hamiltonian + " with the method " +
                                scene.module().integrators[method.integrator].name +
                                " and these conditions: " + text_of(request);
    const FileLocation location = scene.description.integrator.lanes_location.value_or(FileLocation{});
    if (!reason.empty()) throw InputError(location, message + "; reason: " + reason);
    const std::string lanes = available_lanes_text(scene, method, request);
    throw InputError(location, message + (lanes.empty() ? std::string("; `kagero list strategies` shows the kernels")
                                                        : "; available numbers of lanes: " + lanes));
}

const char* refusal_of(const Scene& scene, const KernelInfo& kernel, const MethodChoice& method) {
    const SpaceAndMethod combination{scene.integrated_hamiltonian(), scene.integrated_parameters(), method.integrator,
                                     method.rescaled, scene.straight};
    return kernel.refusal ? kernel.refusal(&combination) : nullptr;
}

}  // namespace kagero
