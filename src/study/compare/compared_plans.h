/// The plans whose kernels `compare` measures.
#pragma once

#include "plan/plan.h"

#include <array>

namespace kagero {

/// How a kernel evaluates H: by code of the kernel module, by machine code that was generated when the scene was
/// loaded, or by an interpreter.
enum class HamiltonianCode { built_in, generated, interpreted };

/// A plan whose kernels are compared.
struct ComparedPlan {
    Plan plan;
    /// True: H is machine code that supplements the kernels of a built-in space. False: H is evaluated as by `render`.
    bool supplements = false;
};

/// Returns the plans for one instruction set. The first is the plan of the scene; for a formula, it contains machine
/// code for the kernels that exist for comparison. If these kernels are not compiled for a built-in space, a second
/// plan follows, in which H is machine code. If it cannot be generated, a pair (kernels, reason) is added to
/// `left_out`.
std::vector<ComparedPlan> plans_for_comparison(SceneDescription scene, Options options,
                                               std::vector<std::array<std::string, 2>>& left_out);

/// Returns how the kernels evaluate the H of a scene.
HamiltonianCode code_of(const Scene& scene);

/// Returns true if the kernel can supplement those of a built-in space. Gangs take the same steps as their packets.
bool can_supplement(const KernelInfo& kernel);

/// Returns the reason why a kernel cannot trace the scene of a plan with a method.
std::string why_unsupported(const Plan& plan, const KernelInfo& kernel, const std::string& method);

}  // namespace kagero
