/// The plan of a run: all decisions that follow from the scene and the options. Plans are made without tracing rays;
/// functions of src/tuning then change the decisions that depend on trial rays.
#pragma once

#include "plan/decisions.h"
#include "plan/run_config.h"

namespace kagero {

/// The result of the trial that chooses the method and its step.
struct MethodTrial {
    std::uint64_t rays = 0;  ///< Number of rays that were traced.
    bool is_stated = false;  ///< True if the scene states the bound, false if it is the default.
    double bound = 0;        ///< Permitted pixel error, in pixels.
    double estimate = 0;     ///< 99th percentile of the pixel error of the trial's rays, or of the uncertainty of the
                             ///< reference if that is greater.
    bool bound_met = false;  ///< True if a method was found whose estimate is within the bound.
    std::string failure_reason;  ///< Reason why no method is known to meet the bound; empty if `bound_met`.
    double operations = 0;       ///< Operations per ray of the method that was found; 0 if none was found.
    /// Share of ill-conditioned rays, whose conditioning exceeds 1000. Their pixel error is divided by
    /// conditioning/1000.
    double ill_conditioned_share = 0;
    std::vector<std::string> remarks;  ///< Warnings for the user about the choice, one line each.
};

/// The result of the trial that chooses the precision, if the options leave it open.
struct PrecisionTrial {
    std::uint64_t rays = 0;         ///< Number of rays that were traced in both precisions; 0: no trial was necessary.
    double difference = 0;          ///< 99th percentile of the distances between ray ends in float and double, pixels.
    std::string reason_for_double;  ///< Reason why rays are traced in double; empty if they are traced in float.
};

/// A plan. It is a value: copies share the scene, and a change of one copy does not affect another.
struct Plan {
    std::shared_ptr<const Scene> scene;
    View view;
    RunConfig run;
    /// For the rays of a list that `run` cannot follow to their end within max_steps, because they circle a hole too
    /// often; empty if the scene states how rays are integrated, or if no method of the space has angular steps.
    std::optional<RunConfig> circling_run;
    std::vector<Plan> media;                        ///< Plans of the media, in the order of the scene file.
    std::optional<MethodTrial> method_trial;        ///< Set by a function of src/tuning.
    std::optional<PrecisionTrial> precision_trial;  ///< Set by a function of src/tuning.
    Decisions decisions;                            ///< The decisions that `explain` prints.
    std::vector<std::string> remarks;               ///< Notes for the user about the scene, one line each.
    double trial_operations = 0;                    ///< Operations of the trial that chose the step bound.
    double load_seconds = 0;                        ///< Time for loading the scene and making the plan.

    /// Returns the plan of a medium: this plan for 0, the space of the scene.
    const Plan& medium(std::uint32_t index) const { return index == 0 ? *this : media[index - 1]; }
    const SceneDescription& description() const { return scene->description; }
    const Module& module() const { return scene->module(); }
    const IntegratorInfo& method() const { return module().integrators[run.method.integrator]; }
    /// Returns the argument of the kernel. The job contains pointers into this plan, which must outlive it.
    Job job() const { return job_of(*scene, view, run); }
};

/// Returns true if the scene states a bound on the pixel error, and no method is known to meet it.
inline bool misses_stated_bound(const Plan& plan) {
    return plan.method_trial && plan.method_trial->is_stated && !plan.method_trial->bound_met;
}

/// Loads a scene and makes its plan. Throws InputError if scene and options state something impossible, such as a
/// method that does not support the space, or a camera inside a surface. For `earlier`, see make_scene.
Plan make_plan(SceneDescription description, const Options& options, Purpose purpose = Purpose::picture,
               const Scene* earlier = nullptr);

/// Makes the plan of a scene that is already loaded. Plan::load_seconds stays 0.
Plan make_plan(std::shared_ptr<const Scene> scene, const Options& options, Purpose purpose);

}  // namespace kagero
