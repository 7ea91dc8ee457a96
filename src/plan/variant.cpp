#include "plan/variant.h"

#include "kernels/assertion.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

const KernelInfo* kernel_of(const Module& module, Strategy strategy, Precision precision) {
    for (std::uint32_t i = 0; i < module.kernel_count; ++i)
        if (module.kernels[i].strategy == strategy && module.kernels[i].precision == precision)
            return &module.kernels[i];
    return nullptr;
}

/// Factor on max_steps for methods with step control. Their mean step is rarely shorter than a tenth of the plan's
/// step.
constexpr double step_control_allowance = 10;

/// Returns RunConfig::max_steps of the variant.
std::uint32_t max_steps_of(const Plan& plan, const Variant& variant) {
    const double factor = info_of(plan, variant).adaptive
                              ? step_control_allowance
                              : std::max(1.0, equivalent_step(plan, variant) / variant.step);
    return static_cast<std::uint32_t>(std::min(1e9, std::ceil(plan.run.max_steps * factor)));
}

}  // namespace

const IntegratorInfo& info_of(const Plan& plan, const Variant& variant) {
    return plan.module().integrators[variant.method.integrator];
}

std::optional<Variant> find_variant(const Plan& plan, const std::string& method, Strategy strategy, Precision precision,
                                    double step) {
    const KernelInfo* kernel = kernel_of(plan.module(), strategy, precision);
    if (!kernel) return {};
    return find_variant(plan, method, *kernel, step);
}

std::optional<Variant> find_variant(const Plan& plan, const std::string& method, const KernelInfo& kernel,
                                    double step) {
    const Module& module = plan.module();
    const Scene& scene = *plan.scene;
    const auto supports = [&](const MethodChoice& choice) {
        return !refusal_of(scene, choice.integrator, choice.rescaled) && !refusal_of(scene, kernel, choice);
    };
    const bool rescales =
        states_rescaling(scene) ||
        (scene.space.info().rescales && scene.description.integrator.rescale == "auto" && !scene.straight);
    for (std::uint32_t i = 0; i < module.integrator_count; ++i) {
        if (method != module.integrators[i].name) continue;
        if (rescales && supports({i, true})) return Variant{{i, true}, &kernel, step, -1};
        if (supports({i, false})) return Variant{{i, false}, &kernel, step, -1};
    }
    return {};
}

Variant variant_with_kernel(const Plan& plan, const KernelInfo& kernel) {
    return {plan.run.method, &kernel, plan.method().adaptive ? plan.run.tolerance : plan.run.step, -1};
}

StepKind step_kind(const Plan& plan, const Variant& variant) {
    return step_kind(*plan.scene, variant.method.integrator, variant.method.rescaled);
}

double equivalent_step(const Plan& plan, const Variant& variant) {
    const Variant current{plan.run.method};
    return step_kind(plan, variant) == step_kind(plan, current)
               ? plan.run.step
               : default_step(plan, variant) * (plan.run.step / default_step(plan, current));
}

double default_step(const Plan& plan, const Variant& variant) {
    return kernel_step(plan, variant,
                       plan.description().integrator.default_step[static_cast<std::size_t>(step_kind(plan, variant))]);
}

double stated_step(const Plan& plan, const Variant& variant) {
    return info_of(plan, variant).adaptive || step_kind(plan, variant) != StepKind::length
               ? variant.step
               : variant.step * plan.scene->unit;
}

double kernel_step(const Plan& plan, const Variant& variant, double stated) {
    return step_kind(plan, variant) == StepKind::length ? stated / plan.scene->unit : stated;
}

RunConfig run_config_with_variant(const Plan& plan, const Variant& variant) {
    RunConfig run = plan.run;
    run.max_steps = max_steps_of(plan, variant);
    run.method = variant.method;
    (info_of(plan, variant).adaptive ? run.tolerance : run.step) = variant.step;
    if (variant.solver_tolerance >= 0) run.solver_tolerance = variant.solver_tolerance;
    run.kernel = variant.kernel;
    return run;
}

Plan plan_with_variant(const Plan& plan, const Variant& variant) {
    Plan other = plan;
    other.run = run_config_with_variant(plan, variant);
    return other;
}

Plan rebuild_plan(const Plan& plan, SceneDescription description, const std::string& isa) {
    KAGERO_ASSERT(!plan.method_trial || !plan.method_trial->bound_met);
    Options options;
    options.isa = isa;
    options.strategy = plan.run.kernel_request.strategy;
    options.precision = plan.run.kernel_request.precision;
    options.threads = plan.run.threads;
    options.schedule = plan.run.schedule;
    Plan other = make_plan(std::move(description), options);
    other.run.max_steps = plan.run.max_steps;
    other.run.step = plan.run.step;  // make_plan does not convert it, because the description is already in Scene::unit
    return other;
}

}  // namespace kagero
