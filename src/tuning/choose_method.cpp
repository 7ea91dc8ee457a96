#include "tuning/choose_method.h"

#include "plan/sampling.h"
#include "tuning/method_search.h"

#include <algorithm>
#include <sstream>

namespace kagero {
namespace {

/// Returns remarks on a stated step or tolerance, which the search replaces.
std::vector<std::string> remarks_on_stated(const Plan& plan) {
    const IntegratorDescription& stated = plan.description().integrator;
    std::vector<std::string> remarks;
    const auto add_remark = [&](const char* key, double value) {
        std::ostringstream remark;
        remark << "integrator." << key << " = " << value << " is not used: to meet integrator.max_pixel_error, "
               << plan.method().name << " runs with " << (plan.method().adaptive ? "tolerance " : "step ")
               << (plan.method().adaptive ? plan.run.tolerance : stated_step(*plan.scene, plan.run));
        remarks.push_back(remark.str());
    };
    if (stated.step_location) add_remark("step", stated.step);
    if (stated.tolerance_location) add_remark("tolerance", stated.tolerance);
    return remarks;
}

/// Returns a remark if many rays are ill-conditioned: their pixel errors are scaled.
std::vector<std::string> remarks_on_ill_conditioned(const MethodTrial& trial) {
    constexpr double min_share = 0.01;
    if (!trial.is_stated || !(trial.ill_conditioned_share > min_share)) return {};
    std::ostringstream remark;
    remark.precision(2);
    remark << "integrator.max_pixel_error: " << 100 * trial.ill_conditioned_share
           << " % of the trial's rays are ill-conditioned: they magnify errors more than 1000 times. The pixel error "
              "of such a ray is divided by magnification/1000, because a pixel near it shows a region many pixels wide";
    return {remark.str()};
}

/// Returns the decision that `explain` prints.
Decision decision_of(const Plan& plan, const MethodTrial& trial) {
    const std::string feature = "choice of method and step by a trial";
    if (!trial.bound_met) return {feature, false, trial.failure_reason};
    if (!trial.failure_reason.empty())
        return {feature + ": " + plan.method().name + " with tolerance " + plain_number(plan.run.tolerance) +
                    ", as in the reference of the trial, because " + trial.failure_reason,
                true,
                {}};
    const std::string step = plan.method().adaptive ? "tolerance " + plain_number(plan.run.tolerance)
                                                    : "step " + plain_number(stated_step(*plan.scene, plan.run));
    std::string chosen = feature + ": " + plan.method().name + " with " + step + " has the fewest operations of those ";
    chosen += "with an error of at most " + plain_number(trial.bound) + " pixels for 99 % of " +
              std::to_string(trial.rays) + " rays; its error is " + plain_number(trial.estimate) + " pixels";
    return {chosen, true, {}};
}

/// Returns the remark that the error may exceed the bound.
std::string remark_on_unmet(const Plan& plan, const MethodTrial& trial, bool runs_reference) {
    std::ostringstream remark;
    remark << (trial.is_stated ? "integrator.max_pixel_error = " : "the default bound on the pixel error, ")
           << trial.bound << (trial.is_stated ? " may not be met: " : ", may not be met: ") << trial.failure_reason
           << "; " << plan.method().name << " runs with ";
    if (runs_reference) remark << "tolerance " << plan.run.tolerance;
    else remark << "its stated or default step";
    return remark.str();
}

/// Returns the plan's configuration with the method of the reference, which is used if no other method is known to meet
/// the bound. Returns nothing if the scene states a method, or if there is no reference.
std::optional<RunConfig> run_config_with_reference(const Plan& plan, const MethodSearch& search) {
    if (search.best || !search.reference || plan.description().integrator.method_location) return {};
    auto run = run_config_with(plan, *search.reference);
    if (!run) return {};
    run->value_weight = MethodSearch::reference_value_weight;
    run->kernel_request.precision = Precision::float64;
    return run;
}

}  // namespace

std::optional<RunConfig> run_config_with(const Plan& plan, Variant variant) {
    KernelRequest request = plan.run.kernel_request;
    request.precision = request.precision.value_or(Precision::float64);
    const KernelInfo* kernel = find_kernel(*plan.scene, variant.method, request);
    if (!kernel) return {};
    variant.kernel = kernel;
    RunConfig run = run_config_with_variant(plan, variant);
    run.max_steps = plan.description().integrator.max_steps;
    return run;
}

bool needs_method_search(const Plan& plan) {
    const IntegratorDescription& stated = plan.description().integrator;
    if (plan.scene->straight) return false;
    return stated.max_pixel_error > 0 || (!stated.step_location && !stated.tolerance_location);
}

Plan choose_method(Plan plan, const RunControl& control) {
    MethodTrial trial;
    trial.is_stated = plan.description().integrator.max_pixel_error > 0;
    trial.bound = trial.is_stated ? method_bound_of(plan.description(), plan.run) : default_max_pixel_error;
    MethodSearch search(plan, trial.bound, control);
    search.run();
    trial.rays = search.rays;
    trial.failure_reason = search.failure_reason;
    if (search.best) {
        const auto run = run_config_with(plan, search.best->variant);
        trial.bound_met = run.has_value();
        trial.operations = search.best->operations;
        if (run) plan.run = *run;
        else trial.failure_reason = "no kernel of the requested strategy and lanes supports the best method";
        const RayErrors& errors = search.best->errors;
        if (const double compared = double(errors.compared + errors.compared_ill_conditioned); compared > 0) {
            trial.estimate = std::max(errors.pixels.p99, search.uncertainty);
            trial.ill_conditioned_share = double(errors.compared_ill_conditioned) / compared;
        }
    }
    const auto reference = run_config_with_reference(plan, search);
    if (reference) {
        plan.run = *reference;
        trial.bound_met = search.is_confirmed;
        trial.estimate = search.uncertainty;
    }
    const auto add_remarks = [&](const std::vector<std::string>& remarks) {
        trial.remarks.insert(trial.remarks.end(), remarks.begin(), remarks.end());
    };
    if (trial.bound_met || reference) plan.decisions.motion = motion_decisions(*plan.scene, plan.run, true);
    if (trial.bound_met) {
        add_remarks(remarks_on_stated(plan));
        add_remarks(remarks_on_ill_conditioned(trial));
    } else if (trial.is_stated || search.is_affordable) {
        add_remarks({remark_on_unmet(plan, trial, reference.has_value())});
    }
    plan.decisions.tuning.push_back(decision_of(plan, trial));
    plan.method_trial = trial;
    return plan;
}

}  // namespace kagero
