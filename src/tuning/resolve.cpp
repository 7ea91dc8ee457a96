#include "tuning/resolve.h"

#include "tuning/autotune.h"
#include "tuning/precision.h"

namespace kagero {

Plan resolve(SceneDescription description, const Options& options, Purpose purpose, const TrialControl& control) {
    Plan plan = make_plan(std::move(description), options, purpose);
    return purpose == Purpose::picture ? choose_by_trial(std::move(plan), control) : plan;
}

Plan choose_by_trial(Plan plan, const TrialControl& control) {
    if (plan.description().integrator.max_pixel_error > 0)
        return autotune(std::move(plan), control.progress, control.time_limit);
    plan.decisions.tuning.push_back(
        {"trial of method, step and precision", false, "the scene states no integrator.max_pixel_error"});
    return choose_precision(std::move(plan));
}

}  // namespace kagero
