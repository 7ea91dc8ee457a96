/// Plans for the frames of an animation.
#pragma once

#include "frames/frame_range.h"
#include "tuning/resolve.h"

#include <mutex>

namespace kagero {

/// Makes the plans of the frames of an animation. The choices are made once for all frames. Geometry and textures that
/// two frames have in common are loaded once.
class FramePlans {
public:
    /// Makes the choices by trial rays. `scene` is the description of any frame. Throws InputError if the animation
    /// cannot be rendered, and Interrupted if `trial_control.stop` is set.
    FramePlans(SceneDescription scene, const Options& options, const RunControl& trial_control);

    /// Returns the plan of a frame. May be called from several threads. Throws InputError, which names the frame, if
    /// the values of the frame are not legal.
    Plan plan(double frame) { return plan_at(frame, {}); }
    /// Returns the plan of one sub-frame: sample number `sample` of all pixels, at its moment of the time during which
    /// the shutter is open (see sub_frames.h).
    Plan sub_frame(double frame, std::uint32_t sample);
    /// Returns the plan of frame 0.
    const Plan& first() const { return first_; }

private:
    Plan plan_at(double frame, std::optional<std::uint32_t> sample);

    SceneDescription scene_;
    Options options_;
    std::optional<AnimationChoice> choice_;  ///< Empty if all frames are the same.
    Plan first_;
    std::shared_ptr<const Scene> latest_;  ///< The scene of the latest plan, whose data the next one can share.
    std::mutex latest_mutex_;
};

/// Reads the scene of every frame of an animation in a range, so that a value that is not legal is found before a frame
/// is rendered. If a range is longer than `max_checked_frames`, only so many frames are read, from the first to
/// the last at equal distances.
/// Throws InputError, which names the frame.
void check_frames(const SceneDescription& scene, const Catalogue& catalogue, const FrameRange& range);
inline constexpr std::uint32_t max_checked_frames = 2000;

}  // namespace kagero
