#include "tuning/autotune.h"

#include "accuracy/error_curves.h"
#include "error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace kagero {
namespace {

/// Number of rays along each edge of the trial's grid.
constexpr std::uint32_t method_trial_grid = 32;
/// Cost of an operation in float, relative to one in double. A register has twice as many lanes in float.
constexpr double float_cost = 0.5;

/// Returns the kernel of the requested strategy and lanes with the curve's method and precision. The curve was measured
/// with packets, but errors depend on neither strategy nor lanes. Returns null if there is no such kernel, or if
/// another method or precision is requested.
const KernelInfo* kernel_for(const Plan& plan, const StudyCurve& curve) {
    if (plan.description().integrator.method_location && curve.method != plan.method().name) return nullptr;
    KernelRequest request = plan.run.kernel_request;
    if (request.precision && *request.precision != curve.precision) return nullptr;
    request.precision = curve.precision;
    const auto variant = find_variant(plan, curve.method, curve.strategy, curve.precision, plan.run.step);
    return find_kernel(*plan.scene, variant->method, request);
}

/// Returns the smallest 99th percentile of the pixel error over all measured points for whose curve there is a kernel;
/// infinity if there is no such point. Points at which more than 1 % of the rays are flips do not count.
double least_error(const Plan& plan, const ErrorCurves& study) {
    constexpr double no_bound = std::numeric_limits<double>::infinity();
    double least = no_bound;
    for (const StudyCurve& curve : study.curves) {
        if (!kernel_for(plan, curve)) continue;
        for (const StudyPoint& point : curve.points)
            if (is_within(point, no_bound, &RayErrors::pixels, study.reference))
                least = std::min(least, point.errors.pixels.p99);
    }
    return least;
}

/// Returns a message with the reason why no measured point is within the bound, and the smallest bound that can be met.
std::string reason_for_no_choice(const Plan& plan, const ErrorCurves& study) {
    if (!is_confirmed(study.reference)) return describe_disagreement(study.reference);
    const bool is_method_stated = plan.description().integrator.method_location.has_value();
    const std::string reason =
        "no measured " + (is_method_stated ? std::string("step of ") + plan.method().name : std::string("method")) +
        " meets the bound" + (study.interrupted ? " within the time limit" : "");
    const double smallest_bound = std::max(least_error(plan, study), study.reference.pixels.p99);
    if (!std::isfinite(smallest_bound)) return reason;
    return reason + "; the smallest bound that can be met is " + plain_number(smallest_bound) + " pixels";
}

/// Returns a remark for each stated step or tolerance that the trial replaces.
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

/// Returns a remark if more than 1 % of the rays are ill-conditioned, because their pixel errors are scaled.
std::vector<std::string> remarks_on_ill_conditioned(const MethodTrial& trial) {
    constexpr double min_share = 0.01;
    if (!(trial.ill_conditioned_share > min_share)) return {};
    std::ostringstream remark;
    remark.precision(2);
    remark << "integrator.max_pixel_error: " << 100 * trial.ill_conditioned_share
           << " % of the trial's rays are ill-conditioned: they magnify errors more than 1000 times. The pixel error "
              "of such a ray is divided by magnification/1000, because a pixel near it shows a region many pixels wide";
    return {remark.str()};
}

/// A measured point, and the kernel of the picture for its method and precision.
struct Choice {
    const StudyCurve* curve = nullptr;
    const StudyPoint* point = nullptr;
    const KernelInfo* kernel = nullptr;
    double cost =
        std::numeric_limits<double>::infinity();  ///< Operations per ray; two operations in float count as one.
};

/// Returns the cheapest measured point that is within the bound, with its kernel. All pointers are null if there is
/// none.
Choice cheapest_within(const Plan& plan, const ErrorCurves& study, double bound) {
    Choice best;
    for (const StudyCurve& curve : study.curves) {
        const KernelInfo* kernel = kernel_for(plan, curve);
        if (!kernel) continue;
        for (const StudyPoint& point : curve.points) {
            const double cost = point.operations * (curve.precision == Precision::float32 ? float_cost : 1);
            if (cost < best.cost && is_within(point, bound, &RayErrors::pixels, study.reference))
                best = {&curve, &point, kernel, cost};
        }
    }
    return best;
}

/// Returns the plan's configuration with the method, step and kernel of a choice.
RunConfig run_config_with_choice(const Plan& plan, const Choice& choice) {
    auto variant = find_variant(plan, choice.curve->method, *choice.kernel, choice.point->step);
    if (choice.curve->has_loose_solver) variant->solver_tolerance = choice.point->solver_tolerance;
    RunConfig run = run_config_with_variant(plan, *variant);
    run.max_steps = plan.description().integrator.max_steps;
    return run;
}

/// Returns the result of the trial. `failure` is the reason why the reference could not be traced, or empty.
MethodTrial trial_of(const Plan& plan, const ErrorCurves& study, const Choice& choice, const std::string& failure) {
    MethodTrial trial;
    trial.rays = study.sample.starts.size();
    trial.bound = plan.description().integrator.max_pixel_error;
    trial.bound_met = choice.point != nullptr;
    if (!choice.point) {
        trial.failure_reason = failure.empty() ? reason_for_no_choice(plan, study) : failure;
        return trial;
    }
    const RayErrors& errors = choice.point->errors;
    if (const double compared = double(errors.compared + errors.compared_ill_conditioned); compared > 0) {
        trial.estimate = std::max(errors.pixels.p99, study.reference.pixels.p99);
        trial.ill_conditioned_share = double(errors.compared_ill_conditioned) / compared;
    }
    return trial;
}

/// Returns the decision that `explain` prints.
Decision decision_of(const MethodTrial& trial) {
    if (trial.bound_met)
        return {"trial of " + std::to_string(trial.rays) + " rays: 99 % have an error of at most " +
                    plain_number(trial.estimate) + " pixels; the bound is " + plain_number(trial.bound) + " pixels",
                true,
                {}};
    return {"choice of method, step and precision by a trial", false,
            "no error of at most " + plain_number(trial.bound) + " pixels was confirmed: " + trial.failure_reason};
}

/// Returns the remark that the bound may not be met.
std::string remark_on_unmet(const Plan& plan, const MethodTrial& trial) {
    std::ostringstream remark;
    remark << "integrator.max_pixel_error = " << trial.bound << " may not be met: " << trial.failure_reason << "; "
           << plan.method().name << " runs with its stated or default step";
    return remark.str();
}

}  // namespace

Plan autotune(Plan plan, const Progress& progress, double time_limit) {
    CurveOptions options;
    options.width = options.height = method_trial_grid;
    options.quick = true;
    options.pixel_bound = plan.description().integrator.max_pixel_error;
    options.deadline = Deadline(time_limit);
    ErrorCurves study;
    std::string failure;
    try {
        study = measure_curves(plan, options, progress);
    } catch (const RunError& error) {  // Without a reference, the plan keeps its method and step.
        failure = error.what();
    }
    const Choice choice = cheapest_within(plan, study, options.pixel_bound);
    const MethodTrial trial = trial_of(plan, study, choice, failure);
    const auto add_remarks = [&](const std::vector<std::string>& remarks) {
        plan.remarks.insert(plan.remarks.end(), remarks.begin(), remarks.end());
    };
    if (trial.bound_met) {
        plan.run = run_config_with_choice(plan, choice);
        plan.decisions.motion = motion_decisions(*plan.scene, plan.run, true);
        add_remarks(remarks_on_stated(plan));
        add_remarks(remarks_on_ill_conditioned(trial));
    } else {
        add_remarks({remark_on_unmet(plan, trial)});
    }
    plan.decisions.tuning.push_back(decision_of(trial));
    plan.method_trial = trial;
    return plan;
}

}  // namespace kagero
