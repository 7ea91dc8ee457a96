#include "tuning/choose_by_trial.h"

#include "tuning/choose_method.h"
#include "tuning/precision.h"

namespace kagero {

Plan choose_by_trial(Plan plan, const RunControl& trial_control) {
    if (needs_method_search(plan)) {
        plan = choose_method(std::move(plan), trial_control);
    } else {
        plan.decisions.tuning.push_back(
            {"choice of method and step by a trial", false,
             plan.scene->straight ? "all rays are straight" : "the scene states the step or the tolerance"});
    }
    return choose_precision(std::move(plan), trial_control.stop);
}

}  // namespace kagero
