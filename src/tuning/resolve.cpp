#include "tuning/resolve.h"

#include "tuning/choose_method.h"
#include "tuning/precision.h"
#include "tuning/step_bound.h"

namespace kagero {

Plan resolve(SceneDescription description, const Options& options, Purpose purpose, const RunControl& trial_control) {
    return tune(make_plan(std::move(description), options, purpose), options, purpose, trial_control);
}

Plan tune(Plan plan, const Options& options, Purpose purpose, const RunControl& trial_control) {
    plan = choose_step_bound(std::move(plan), options, purpose);
    return purpose == Purpose::picture ? choose_by_trial(std::move(plan), trial_control) : plan;
}

Plan choose_by_trial(Plan plan, const RunControl& trial_control) {
    if (needs_method_search(plan)) {
        plan = choose_method(std::move(plan), trial_control);
    } else {
        plan.decisions.tuning.push_back({"choice of method and step by a trial", false,
                                         plan.scene->straight ? "all rays are straight"
                                                              : "the scene states the step or the tolerance"});
    }
    return choose_precision(std::move(plan), trial_control.stop);
}

}  // namespace kagero
