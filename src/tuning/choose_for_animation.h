/// The choices that trial rays make once for all frames of an animation, so that a film does not flicker.
#pragma once

#include "plan/variant.h"
#include "render/run_report.h"

namespace kagero {

/// The choices for all frames. They do not depend on the frames that are rendered.
struct AnimationChoice {
    std::vector<double> frames;          ///< The frames whose rays were traced.
    std::optional<MethodChoice> method;  ///< Empty if no frame of the trial needs a choice of the method.
    double step = 0;                     ///< Step or tolerance of the method, in the unit of the scene file.
    double value_weight = 1;             ///< RunConfig::value_weight.
    bool use_float = false;              ///< True if float is accurate enough in all frames of the trial.
    std::string reason_for_double;       ///< Empty if `use_float`.
    MethodTrial trial;                   ///< The trials of all frames together, if there is a method.
    std::shared_ptr<const Scene> scene;  ///< The scene of one of the frames; other frames can share its data.
};

/// Returns true if the scene is animated and at least one key depends on the frame.
bool has_changing_frames(const SceneDescription& scene);

/// Returns the plan of a frame with its step bound, before the choices of trials. `earlier`, if not null, is the scene
/// of another frame (see make_scene). `sample`, if stated, is one of film.spp samples: the plan then has one ray per
/// pixel, which is the same ray of all pixels. Throws InputError, which names the frame, and Interrupted if
/// `control.stop` is set.
Plan plan_of_frame(const SceneDescription& scene, double frame, const Options& options, const Scene* earlier = nullptr,
                   std::optional<std::uint32_t> sample = {}, const RunControl& control = {});

/// Traces trial rays in the first, the middle and the last frame of an animation. Chooses the method of the frame whose
/// choice needs the most operations per ray, and the smallest of its steps or tolerances that the frames need. Chooses
/// float only if it is accurate enough in all of these frames.
AnimationChoice choose_for_animation(const SceneDescription& scene, const Options& options,
                                     const RunControl& control = {});

/// Returns the plan of a frame with the choices for all frames. The plan must have its step bound, but no choices of a
/// trial. If the space of the frame does not support the method, choose_by_trial makes the choices for this frame.
Plan with_choice(Plan plan, const AnimationChoice& choice, const RunControl& control = {});

}  // namespace kagero
