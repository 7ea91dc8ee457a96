/// Everything that tracing a scene needs, decided from the scene and the options alone; no ray is traced to make it.
#pragma once

#include "plan/decisions.h"
#include "plan/run_config.h"

namespace kagero {

/// How the method was chosen, where the scene states a bound on the error.
struct MethodTrial {
    std::uint64_t rays = 0;
    double bound = 0, estimate = 0;  ///< pixels; of the error of 99 % of the rays
    bool met = false;
    std::string why_not;         ///< where it is not met
    double ill_conditioned =
        0;  ///< share of the rays that turn their neighbours apart so much that their pixels count as larger
};

/// The result of tracing some rays in double and in float, where the options leave the precision open.
struct PrecisionTrial {
    std::uint64_t rays = 0;
    double apart = 0;     ///< pixels, between the ends in double and in float; of 99 % of the rays
    std::string why_not;  ///< empty: rays are followed in float
};

/// A value: copies share the scene, and a change to one is no change to another.
struct Plan {
    std::shared_ptr<const Scene> scene;
    View view;
    RunConfig run;
    std::optional<MethodTrial> method_trial;        ///< made by tuning/
    std::optional<PrecisionTrial> precision_trial;  ///< made by tuning/
    Decisions decisions;                            ///< with their reasons, as they were made
    std::vector<std::string> remarks;               ///< one line each, of what the user may want to know of the scene
    double load_seconds = 0;

    const SceneDescription& description() const { return scene->description; }
    const Module& module() const { return scene->module(); }
    const IntegratorInfo& method() const { return module().integrators[run.method.integrator]; }
    /// Points into this plan.
    Job job() const { return job_of(*scene, view, run); }
};

/// Loads a scene and makes the decisions that follow from it. Throws InputError for what the scene or the options ask
/// that cannot be done: a refused method, a camera inside a surface …
Plan make_plan(SceneDescription description, const Options& options, Purpose purpose = Purpose::picture);

/// The same for a loaded scene.
Plan make_plan(std::shared_ptr<const Scene> scene, const Options& options, Purpose purpose);

}  // namespace kagero
