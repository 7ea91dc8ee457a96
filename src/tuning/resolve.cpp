#include "tuning/resolve.h"

#include "tuning/step_bound.h"

namespace kagero {

Plan resolve(SceneDescription description, const Options& options, Purpose purpose, const RunControl& trial_control) {
    return tune(make_plan(std::move(description), options, purpose), options, purpose, trial_control);
}

Plan tune(Plan plan, const Options& options, Purpose purpose, const RunControl& trial_control) {
    plan = choose_step_bound(std::move(plan), options, purpose, trial_control);
    if (purpose != Purpose::picture) return plan;
    if (!has_changing_frames(plan.description())) return choose_by_trial(std::move(plan), trial_control);
    return with_choice(std::move(plan), choose_for_animation(plan.description(), options, trial_control),
                       trial_control);
}

}  // namespace kagero
