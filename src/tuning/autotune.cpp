#include "tuning/autotune.h"

#include "accuracy/error_curves.h"
#include "error.h"

#include <algorithm>
#include <sstream>

namespace kagero {
namespace {

/// Rays along an edge of the grid.
constexpr std::uint32_t pilot_grid = 32;
/// The cost of an operation in float, in operations in double: there are twice as many lanes.
constexpr double float_cost = 0.5;

/// The kernel that does for the plan what a curve shows of packets: by the strategy and lanes asked for, as errors do
/// not depend on them. Null where there is none, or the scene states another method or precision.
const KernelInfo* kernel_for(const Plan& plan, const StudyCurve& curve) {
    if (plan.description().integrator.method_place && curve.method != plan.method().name) return nullptr;
    KernelWish wish = plan.run.wish;
    if (wish.precision && *wish.precision != curve.precision) return nullptr;
    wish.precision = curve.precision;
    return find_kernel(*plan.scene,
                       find_variant(plan, curve.method, curve.strategy, curve.precision, plan.run.step)->method, wish);
}

/// Why no point of a study is within the bound.
std::string why_not(const ErrorCurves& study, const Plan& plan) {
    if (!is_known(study.reference)) return what_is_unknown(study.reference);
    return "by no " +
           (plan.description().integrator.method_place ? std::string("step of ") + plan.method().name
                                                       : std::string("method")) +
           " that was tried" + (study.interrupted ? " before its time was up" : "");
}

/// A stated step or tolerance is used only if no method is seen to meet the bound.
std::vector<std::string> remarks_on_stated(const Plan& plan) {
    const IntegratorDescription& stated = plan.description().integrator;
    std::vector<std::string> remarks;
    const auto say = [&](const char* key, double value) {
        std::ostringstream remark;
        remark << "integrator." << key << " = " << value << " is not taken: for integrator.max_pixel_error, "
               << plan.method().name << " takes " << (plan.method().adaptive ? "tolerance " : "step ")
               << (plan.method().adaptive ? plan.run.tolerance : stated_step(*plan.scene, plan.run));
        remarks.push_back(remark.str());
    };
    if (stated.step_place) say("step", stated.step);
    if (stated.tolerance_place) say("tolerance", stated.tolerance);
    return remarks;
}

/// Where rays diverge strongly from their neighbours, a pixel counts as larger than that of a straight ray.
std::vector<std::string> remarks_on_ill_conditioned(const MethodTrial& trial) {
    constexpr double few = 0.01;
    if (!(trial.ill_conditioned > few)) return {};
    std::ostringstream remark;
    remark.precision(2);
    remark << "integrator.max_pixel_error: " << 100 * trial.ill_conditioned
           << " % of the pilot's rays turn their neighbours apart more than a thousandfold; the pixel of such a ray is "
              "a thousandth of what it shows, "
              "not that of a straight ray";
    return {remark.str()};
}

struct Choice {
    const StudyCurve* curve = nullptr;
    const StudyPoint* point = nullptr;
    const KernelInfo* kernel = nullptr;
    double cost = std::numeric_limits<double>::infinity();
};

/// The cheapest point of a study that is within the bound, and by what kernel; nulls where there is none.
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

/// The plan's configuration with the method, step and kernel of a choice.
RunConfig run_by(const Plan& plan, const Choice& choice) {
    auto variant = find_variant(plan, choice.curve->method, *choice.kernel, choice.point->step);
    if (choice.curve->loose) variant->solver_tolerance = choice.point->solver_tolerance;
    RunConfig run = run_by(plan, *variant);
    run.max_steps = plan.description().integrator.max_steps;
    return run;
}

/// The result of the trial; `failure` is the reason why no reference could be traced, or empty.
MethodTrial trial_of(const Plan& plan, const ErrorCurves& study, const Choice& choice, const std::string& failure) {
    MethodTrial trial;
    trial.rays = study.sample.starts.size(), trial.bound = plan.description().integrator.max_pixel_error,
    trial.met = choice.point != nullptr;
    if (!choice.point) {
        trial.why_not = failure.empty() ? why_not(study, plan) : failure;
        return trial;
    }
    const RayErrors& errors = choice.point->errors;
    if (const double compared = double(errors.compared + errors.ill); compared > 0) {
        trial.estimate = std::max(errors.pixels.p99, study.reference.pixels.p99);
        trial.ill_conditioned = double(errors.ill) / compared;
    }
    return trial;
}

Decision decision_of(const MethodTrial& trial) {
    if (trial.met)
        return {"a pilot of " + std::to_string(trial.rays) + " rays: 99 % of them within " +
                    plain_number(trial.estimate) + " pixels, of " + plain_number(trial.bound) + " allowed",
                true,
                {}};
    return {"what a pilot chose", false,
            "no way to keep within " + plain_number(trial.bound) + " pixels was seen: " + trial.why_not};
}

std::string remark_on_unmet(const Plan& plan, const MethodTrial& trial) {
    std::ostringstream remark;
    remark << "integrator.max_pixel_error = " << trial.bound << " is not seen to be met: " << trial.why_not << "; "
           << plan.method().name << " takes its own step";
    return remark.str();
}

}  // namespace

Plan autotune(Plan plan, const Progress& progress, double time_limit) {
    CurveOptions options;
    options.width = options.height = pilot_grid;
    options.quick = true, options.pixel_bound = plan.description().integrator.max_pixel_error;
    options.deadline = Deadline(time_limit);
    ErrorCurves study;
    std::string failure;
    try {
        study = measure_curves(plan, options, progress);
    } catch (const RunError& error) {  // there is nothing to measure by: the picture can be drawn all the same
        failure = error.what();
    }
    const Choice choice = cheapest_within(plan, study, options.pixel_bound);
    const MethodTrial trial = trial_of(plan, study, choice, failure);
    const auto remark = [&](const std::vector<std::string>& more) {
        plan.remarks.insert(plan.remarks.end(), more.begin(), more.end());
    };
    if (trial.met) {
        plan.run = run_by(plan, choice);
        plan.decisions.motion = motion_decisions(*plan.scene, plan.run, true);
        remark(remarks_on_stated(plan));
        remark(remarks_on_ill_conditioned(trial));
    } else {
        remark({remark_on_unmet(plan, trial)});
    }
    plan.decisions.tuning.push_back(decision_of(trial));
    plan.method_trial = trial;
    return plan;
}

}  // namespace kagero
