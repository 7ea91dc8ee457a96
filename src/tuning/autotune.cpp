#include "tuning/autotune.h"

#include "error.h"
#include "study/error_study.h"
#include "plan/kernels.h"
#include "tuning/precision.h"

#include <algorithm>
#include <sstream>

namespace kagero {
namespace {

/// Rays along an edge of the grid.
constexpr std::uint32_t pilot_grid = 32;
/// What costs in float what 1 costs in double: lanes are twice as many.
constexpr double float_cost = 0.5;

/// The kernel that does for the plan what a curve shows of packets: by the strategy and lanes asked for, as errors do not depend on them.
/// Null where there is none, or the scene states another method or precision.
const KernelInfo* kernel_for(Plan& plan, const StudyCurve& curve) {
    if (plan.scene.integrator.method_place && curve.method != plan.scene.integrator.method) return nullptr;
    if (plan.options.precision != "auto" && plan.options.precision != name_of(curve.precision)) return nullptr;
    KernelWish wish = wish_of(plan);
    wish.precision = curve.precision;
    const PlanAs as(plan, *find_variant(plan, curve.method, curve.strategy, curve.precision, plan.job.step));
    return find_kernel(plan, wish);
}

/// The scene's own words for what the plan does now.
void tell_scene(Plan& plan, const StudyCurve& curve, const StudyPoint& point) {
    IntegratorDescription& text = plan.scene.integrator;
    text.method = curve.method;
    if (curve.info->adaptive) text.tolerance = point.step;
    else text.step = point.stated_step;
    text.solver_tolerance = plan.job.solver_tolerance;
}

/// Why no point of a study is within the bound.
std::string why_not(const ErrorStudy& study, const IntegratorDescription& stated) {
    if (!is_known(study.reference)) return what_is_unknown(study.reference);
    return "by no " + (stated.method_place ? "step of " + stated.method : std::string("method")) + " that was tried" +
           (study.interrupted ? " before its time was up" : "");
}

/// What a scene states of steps is for where nothing is seen to meet the bound.
void remark_on_stated(Plan& plan, const IntegratorDescription& stated, bool adaptive) {
    const IntegratorDescription& chosen = plan.scene.integrator;
    const auto say = [&](const char* key, double value) {
        std::ostringstream remark;
        remark << "integrator." << key << " = " << value << " is not taken: for integrator.max_pixel_error, " << chosen.method << " takes "
               << (adaptive ? "tolerance " : "step ") << (adaptive ? chosen.tolerance : chosen.step);
        plan.remarks.push_back(remark.str());
    };
    if (stated.step_place) say("step", stated.step);
    if (stated.tolerance_place) say("tolerance", stated.tolerance);
}

/// Of rays that turn their neighbours apart a pixel is not that of a straight ray.
void remark_on_ill_conditioned(Plan& plan) {
    constexpr double few = 0.01;
    if (!(plan.pilot->ill_conditioned > few)) return;
    std::ostringstream remark;
    remark.precision(2);
    remark << "integrator.max_pixel_error: " << 100 * plan.pilot->ill_conditioned
           << " % of the pilot's rays turn their neighbours apart more than a thousandfold; the pixel of such a ray is a thousandth of what it shows, "
              "not that of a straight ray";
    plan.remarks.push_back(remark.str());
}

struct Choice {
    const StudyCurve* curve = nullptr;
    const StudyPoint* point = nullptr;
    const KernelInfo* kernel = nullptr;
    double cost = std::numeric_limits<double>::infinity();
};

/// The cheapest point of a study that is within the bound, and by what kernel; nulls where there is none.
Choice cheapest_within(Plan& plan, const ErrorStudy& study, double bound) {
    Choice best;
    for (const StudyCurve& curve : study.curves) {
        const KernelInfo* kernel = kernel_for(plan, curve);
        if (!kernel) continue;
        for (const StudyPoint& point : curve.points) {
            const double cost = point.operations * (curve.precision == Precision::float32 ? float_cost : 1);
            if (cost < best.cost && is_within(point, bound, &RayErrors::pixels, study.reference)) best = {&curve, &point, kernel, cost};
        }
    }
    return best;
}

void take(Plan& plan, const ErrorStudy& study, const Choice& choice) {
    const auto& [curve, point, kernel, cost] = choice;
    if (const double compared = double(point->errors.compared + point->errors.ill); compared > 0) {
        plan.pilot->estimate = std::max(point->errors.pixels.p99, study.reference.pixels.p99);
        plan.pilot->ill_conditioned = double(point->errors.ill) / compared;
    }
    auto variant = find_variant(plan, curve->method, *kernel, point->step);
    if (curve->loose) variant->solver_tolerance = point->solver_tolerance;
    follow(plan, *variant);
    plan.job.max_steps = plan.scene.integrator.max_steps;
    const IntegratorDescription stated = plan.scene.integrator;
    tell_scene(plan, *curve, *point);
    remark_on_stated(plan, stated, curve->info->adaptive);
    remark_on_ill_conditioned(plan);
}

}  // namespace

void fit_to_error(Plan& plan, const Progress& progress, double time_limit) {
    const double bound = plan.scene.integrator.max_pixel_error;
    StudyOptions options;
    options.width = options.height = pilot_grid;
    options.quick = true, options.pixel_bound = bound;
    options.threads = plan.threads;
    options.deadline = Deadline(time_limit);
    ErrorStudy study;
    std::string why;
    try {
        study = study_error(plan, options, progress);
    } catch (const RunError& error) {  // there is nothing to measure by: the picture can be drawn all the same
        why = error.what();
    }
    const Choice choice = cheapest_within(plan, study, bound);
    Pilot& pilot = plan.pilot.emplace();
    pilot.rays = study.sample.starts.size(), pilot.bound = bound, pilot.met = choice.point != nullptr;
    if (choice.point) return take(plan, study, choice);
    pilot.why_not = why.empty() ? why_not(study, plan.scene.integrator) : why;
    std::ostringstream remark;
    remark << "integrator.max_pixel_error = " << bound << " is not seen to be met: " << pilot.why_not << "; " << plan.scene.integrator.method << " takes its own step";
    plan.remarks.push_back(remark.str());
}

void settle(Plan& plan, const Progress& progress, double time_limit) {
    if (plan.scene.integrator.max_pixel_error > 0) fit_to_error(plan, progress, time_limit);
    else choose_precision(plan);
}

}  // namespace kagero
