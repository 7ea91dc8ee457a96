/// Selection of the kernel that traces a scene, among the kernels of a module.
#pragma once

#include "plan/scene.h"

namespace kagero {

/// A method of the module, with or without time rescaling of H.
struct MethodChoice {
    std::uint32_t integrator = 0;  ///< Index into Module::integrators.
    bool rescaled = false;         ///< True: Ω(q)·(H − H0) is integrated instead of H.
};

/// Conditions on a kernel. An empty member, or 0 lanes, sets no condition.
struct KernelRequest {
    std::optional<Strategy> strategy;
    std::optional<Precision> precision;
    std::uint32_t lanes = 0;   ///< Rays per packet; 1: scalar.
    std::string isa = "auto";  ///< Instruction set that was requested for the module.
};
/// Returns the conditions that options and scene state.
KernelRequest make_kernel_request(const Scene& scene, const Options& options);

/// Returns a kernel that meets all conditions and supports the scene's space with the method. If there is none, throws
/// InputError with the available numbers of lanes.
const KernelInfo& choose_kernel(const Scene& scene, const MethodChoice& method, const KernelRequest& request);

/// Returns the same kernel as choose_kernel, or null if there is none.
const KernelInfo* find_kernel(const Scene& scene, const MethodChoice& method, const KernelRequest& request);

/// Returns null if the kernel supports the scene's space with the method, else the reason. Does not check whether the
/// method itself supports the space; refusal_of in scene.h checks that.
const char* refusal_of(const Scene& scene, const KernelInfo& kernel, const MethodChoice& method);

}  // namespace kagero
