/// Variants of a plan that trace the rays of its scene with another method, kernel or step.
#pragma once

#include "plan/plan.h"

namespace kagero {

/// A combination of method, kernel and step for the rays of a plan.
struct Variant {
    MethodChoice method;
    const KernelInfo* kernel = nullptr;
    double step = 0;               ///< Step, or the tolerance of a method with step control.
    double solver_tolerance = -1;  ///< Relative solver tolerance; negative: that of the plan.
};

/// Returns the description of the variant's method.
const IntegratorInfo& info_of(const Plan& plan, const Variant& variant);

/// Returns the variant that `render` would use for the method of this name. Returns nothing if the module has no such
/// method or kernel, or if the method does not support the scene.
std::optional<Variant> find_variant(const Plan& plan, const std::string& method, Strategy strategy, Precision precision,
                                    double step);

/// Returns the variant of a method with a given kernel. Returns nothing if the kernel or the scene does not support the
/// method.
std::optional<Variant> find_variant(const Plan& plan, const std::string& method, const KernelInfo& kernel, double step);

/// Returns the plan's method and step with another kernel.
Variant variant_with_kernel(const Plan& plan, const KernelInfo& kernel);

/// Returns the unit in which the steps of a variant are counted.
StepKind step_kind(const Plan& plan, const Variant& variant);
/// Returns the plan's step if the variant counts steps in the same unit. Otherwise returns the space's default step in
/// the unit of the variant, times the ratio of the plan's step to the default in the plan's unit.
double equivalent_step(const Plan& plan, const Variant& variant);
/// Returns the space's default step for the variant, in the unit of the kernels.
double default_step(const Plan& plan, const Variant& variant);
/// Returns the variant's step or tolerance in the unit of the scene file.
double stated_step(const Plan& plan, const Variant& variant);
/// Converts a step of the scene file, `stated`, to the unit of the kernels.
double kernel_step(const Plan& plan, const Variant& variant, double stated);

/// Returns the plan's configuration with the variant's method, kernel and step. The limit of steps is scaled so that a
/// ray can cover the same path as with the plan's step.
RunConfig run_config_with_variant(const Plan& plan, const Variant& variant);
/// Returns the plan with `run_config_with_variant`.
Plan plan_with_variant(const Plan& plan, const Variant& variant);

/// Returns a new plan for the whole film of a description that differs from the plan's in film or lanes, with the
/// instruction set `isa`. The method is that of the description, so the plan's method must not have been chosen by
/// trial rays.
Plan rebuild_plan(const Plan& plan, SceneDescription description, const std::string& isa);

}  // namespace kagero
