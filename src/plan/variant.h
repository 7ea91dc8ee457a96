/// Variants of a plan: the rays of the plan's scene are traced with another method, kernel or step.
#pragma once

#include "plan/plan.h"

namespace kagero {

/// A combination of method, kernel and step for the rays of a plan.
struct Variant {
    MethodChoice method;
    const KernelInfo* kernel = nullptr;
    double step = 0;               ///< Step in the unit of the kernels, or the tolerance of a method with step control.
    double solver_tolerance = -1;  ///< Relative solver tolerance; negative: that of the plan.
};

/// Returns the description of the variant's method.
const IntegratorInfo& info_of(const Plan& plan, const Variant& variant);

/// Returns the variant of the named method with the module's first kernel of this strategy and precision. The variant
/// uses time rescaling if the scene states Ω or uses the Ω of the space, and method and kernel support it. Returns
/// nullopt if the module has no such method or kernel, or if method or kernel do not support the scene.
std::optional<Variant> find_variant(const Plan& plan, const std::string& method, Strategy strategy, Precision precision,
                                    double step);

/// Returns the variant of the named method with the given kernel. Returns nullopt if the module has no such method, or
/// if method or kernel do not support the scene.
std::optional<Variant> find_variant(const Plan& plan, const std::string& method, const KernelInfo& kernel, double step);

/// Returns the variant with the plan's method and step and the given kernel.
Variant variant_with_kernel(const Plan& plan, const KernelInfo& kernel);

/// Returns the unit in which the steps of a variant are measured.
StepKind step_kind(const Plan& plan, const Variant& variant);
/// Returns the plan's step if the variant measures steps in the same unit. Otherwise, returns the space's default step
/// for the variant times the ratio of the plan's step to the space's default step for the plan's method.
double equivalent_step(const Plan& plan, const Variant& variant);
/// Returns the space's default step for the variant, in the unit of the kernels.
double default_step(const Plan& plan, const Variant& variant);
/// Returns the variant's step or tolerance in the unit of the scene file.
double stated_step(const Plan& plan, const Variant& variant);
/// Converts a step of the scene file, `stated`, to the unit of the kernels.
double kernel_step(const Plan& plan, const Variant& variant, double stated);

/// Returns the plan's configuration with the variant's method, kernel and step. If steps may be shorter than those of
/// the plan, max_steps is increased so that a ray can cover the same path.
RunConfig run_config_with_variant(const Plan& plan, const Variant& variant);
/// Returns the plan with the configuration that run_config_with_variant returns.
Plan plan_with_variant(const Plan& plan, const Variant& variant);

/// Makes a new plan with the instruction set `isa` from a description that differs from that of `plan` only in film or
/// lanes. The new plan covers the whole film. Its method is that of the description, so the method of `plan` must not
/// have been chosen by trial rays.
Plan rebuild_plan(const Plan& plan, SceneDescription description, const std::string& isa);

}  // namespace kagero
