/// Which of a module's kernels runs a job.
#pragma once

#include "plan/plan.h"

#include <optional>

namespace kagero {

/// What is asked of a kernel; empty, or 0 lanes, leaves the choice.
struct KernelWish {
    std::optional<Strategy> strategy;
    std::optional<Precision> precision;
    std::uint32_t lanes = 0;  ///< rays at a time; 1: scalar
};
KernelWish wish_of(const Plan& plan);

/// The first kernel that has all that is asked for and serves the plan's space and method. Throws InputError that names those
/// there are.
const KernelInfo& choose_kernel(const Plan& plan, const KernelWish& wish);

/// The same; null where there is none.
const KernelInfo* find_kernel(const Plan& plan, const KernelWish& wish);

/// Null where a kernel serves the plan's space by a method, else why not; what the module itself refuses is not asked here.
const char* refusal_of(const Plan& plan, const KernelInfo& kernel, std::uint32_t integrator, bool rescaled);

/// "", "gradient", "stages", "auto-vectorized" or "gang".
const char* name_of(Form);

}  // namespace kagero
