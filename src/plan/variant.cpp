#include "plan/variant.h"

#include "plan/kernels.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

const KernelInfo* kernel_of(const Module& module, Strategy strategy, Precision precision) {
    for (std::uint32_t i = 0; i < module.kernel_count; ++i)
        if (module.kernels[i].strategy == strategy && module.kernels[i].precision == precision) return &module.kernels[i];
    return nullptr;
}

/// Steps of adaptive methods are as long as they like; on the average those of a tenth of the scene's are rare.
constexpr double adaptive_allowance = 10;

std::uint32_t allowed_steps(const Plan& plan, const Variant& variant) {
    const double share = info_of(plan, variant).adaptive ? adaptive_allowance : std::max(1.0, usual_step(plan, variant) / variant.step);
    return static_cast<std::uint32_t>(std::min(1e9, std::ceil(plan.job.max_steps * share)));
}

}  // namespace

const IntegratorInfo& info_of(const Plan& plan, const Variant& variant) {
    return plan.module->integrators[variant.integrator];
}

std::optional<Variant> find_variant(const Plan& plan, const std::string& method, Strategy strategy, Precision precision,
                                    double step) {
    const KernelInfo* kernel = kernel_of(*plan.module, strategy, precision);
    if (!kernel) return {};
    return find_variant(plan, method, *kernel, step);
}

std::optional<Variant> find_variant(const Plan& plan, const std::string& method, const KernelInfo& kernel, double step) {
    const Module& module = *plan.module;
    const auto serves = [&](std::uint32_t i, bool rescaled) {
        return !refusal_of(plan, i, rescaled) && !refusal_of(plan, kernel, i, rescaled);
    };
    const bool rescales =
        states_rescaling(plan) || (module.hamiltonians[plan.hamiltonian].rescales && plan.scene.integrator.rescale == "auto" && !plan.straight);
    for (std::uint32_t i = 0; i < module.integrator_count; ++i) {
        if (method != module.integrators[i].name) continue;
        if (rescales && serves(i, true)) return Variant{i, true, &kernel, step, -1};
        if (serves(i, false)) return Variant{i, false, &kernel, step, -1};
    }
    return {};
}

StepKind step_kind(const Plan& plan, const Variant& variant) {
    return step_kind(plan, variant.integrator, variant.rescaled);
}

double usual_step(const Plan& plan, const Variant& variant) {
    const Variant own{plan.job.integrator, plan.job.rescaled};
    return step_kind(plan, variant) == step_kind(plan, own) ? plan.job.step : default_step(plan, variant) * (plan.job.step / default_step(plan, own));
}

double default_step(const Plan& plan, const Variant& variant) {
    return job_step(plan, variant, plan.scene.integrator.default_step[static_cast<std::size_t>(step_kind(plan, variant))]);
}

double stated_step(const Plan& plan, const Variant& variant) {
    return info_of(plan, variant).adaptive || step_kind(plan, variant) != StepKind::length ? variant.step : variant.step * plan.unit;
}

double job_step(const Plan& plan, const Variant& variant, double stated) {
    return step_kind(plan, variant) == StepKind::length ? stated / plan.unit : stated;
}

Job job_as(const Plan& plan, const Variant& variant) {
    Job job = plan.job;
    job.max_steps = allowed_steps(plan, variant);
    job.integrator = variant.integrator, job.rescaled = variant.rescaled;
    (info_of(plan, variant).adaptive ? job.tolerance : job.step) = variant.step;
    if (variant.solver_tolerance >= 0) job.solver_tolerance = variant.solver_tolerance;
    return job;
}

void follow(Plan& plan, const Variant& variant) {
    plan.job = job_as(plan, variant);
    plan.kernel = variant.kernel;
}

PlanAs::PlanAs(Plan& plan, const Variant& variant) : plan_(plan), job_(plan.job), kernel_(plan.kernel), threads_(plan.threads) {
    follow(plan, variant);
}

PlanAs::~PlanAs() {
    plan_.job = job_, plan_.kernel = kernel_, plan_.threads = threads_;
}

}  // namespace kagero
