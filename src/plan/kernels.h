/// Which of a module's kernels runs a scene.
#pragma once

#include "plan/scene.h"

namespace kagero {

/// A method of the module, with H rescaled or not.
struct MethodChoice {
    std::uint32_t integrator = 0;  ///< an index into Module::integrators
    bool rescaled = false;         ///< integrate Ω(q)·(H − H0) instead of H
};

/// Conditions on a kernel. An empty member, or 0 lanes, sets no condition.
struct KernelWish {
    std::optional<Strategy> strategy;
    std::optional<Precision> precision;
    std::uint32_t lanes = 0;  ///< rays at a time; 1: scalar
    std::string isa = "auto";  ///< the module was chosen by it
};
/// The conditions that options and scene state.
KernelWish wish_of(const Scene& scene, const Options& options);

/// The first kernel that meets all conditions and serves the scene's space by the method. Throws InputError, which
/// lists the available kernels.
const KernelInfo& choose_kernel(const Scene& scene, const MethodChoice& method, const KernelWish& wish);

/// The same; null where there is none.
const KernelInfo* find_kernel(const Scene& scene, const MethodChoice& method, const KernelWish& wish);

/// Null where a kernel serves the scene's space by a method, else the reason. What the module refuses for every kernel
/// is not checked here.
const char* refusal_of(const Scene& scene, const KernelInfo& kernel, const MethodChoice& method);

}  // namespace kagero
