/// The rays of a scene by another method than the scene's own, through the same kernels and loop.
#pragma once

#include "plan/plan.h"

namespace kagero {

/// One way of integrating the rays of a plan.
struct Variant {
    MethodChoice method;
    const KernelInfo* kernel = nullptr;
    double step = 0;               ///< of adaptive methods: the tolerance
    double solver_tolerance = -1;  ///< of implicit equations; negative: the plan's
};

const IntegratorInfo& info_of(const Plan& plan, const Variant& variant);

/// The variant that `render` would use for a method of this name; nothing where the module has no such method, or the
/// space or the scene refuses it.
std::optional<Variant> find_variant(const Plan& plan, const std::string& method, Strategy strategy, Precision precision,
                                    double step);

/// The same by one of the module's kernels, which may refuse it too.
std::optional<Variant> find_variant(const Plan& plan, const std::string& method, const KernelInfo& kernel, double step);

/// The plan's own method, by one of the module's kernels.
Variant own_variant(const Plan& plan, const KernelInfo& kernel);

/// The unit in which the steps of a variant are counted.
StepKind step_kind(const Plan& plan, const Variant& variant);
/// The plan's step, for a variant whose steps have the same unit; else in the same proportion to the space's default
/// for it.
double usual_step(const Plan& plan, const Variant& variant);
/// The space's default, where the scene's own step does not count.
double default_step(const Plan& plan, const Variant& variant);
/// The variant's step, or tolerance, as a scene states it; and such a step as the kernels count it.
double stated_step(const Plan& plan, const Variant& variant);
double kernel_step(const Plan& plan, const Variant& variant, double stated);

/// The plan's configuration by a variant. A ray may take as many steps as cover the path that the scene allows.
RunConfig run_by(const Plan& plan, const Variant& variant);
/// The plan with that configuration.
Plan plan_by(const Plan& plan, const Variant& variant);

/// The plan of a description that differs from the plan's in film or lanes, by any instruction set, for the whole film.
/// The method is that of the description: a plan whose method was chosen by trial rays cannot be made anew.
Plan remade(const Plan& plan, SceneDescription description, const std::string& isa);

}  // namespace kagero
