#include "tuning/resolve.h"

#include "tuning/autotune.h"
#include "tuning/precision.h"

namespace kagero {

Plan resolve(SceneDescription description, const Options& options, Purpose purpose, const TrialWatch& watch) {
    Plan plan = make_plan(std::move(description), options, purpose);
    return purpose == Purpose::picture ? tuned(std::move(plan), watch) : plan;
}

Plan tuned(Plan plan, const TrialWatch& watch) {
    if (plan.description().integrator.max_pixel_error > 0)
        return autotune(std::move(plan), watch.progress, watch.time_limit);
    plan.decisions.tuning.push_back({"a pilot that chooses method, step and precision", false,
                                     "the scene states them, or takes the space's (integrator.max_pixel_error)"});
    return choose_precision(std::move(plan));
}

}  // namespace kagero
