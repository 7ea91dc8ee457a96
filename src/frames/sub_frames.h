/// Pictures of an animation while the shutter is open.
#pragma once

#include "frames/frame_plans.h"

namespace kagero {

/// Returns true if a picture is the mean of sub-frames: keys depend on the frame, and the shutter is open for some
/// time.
bool has_sub_frames(const SceneDescription& scene);

/// Renders frame number `frame` into a film that film_of(plan) returned. The picture consists of film.spp sub-frames,
/// with one ray per pixel each. Sub-frame k shows the scene at the moment frame + shutter · (k + ½)/spp, with all rays
/// displaced by the same part of a pixel. Sub-frames are added in the order of their numbers. If the run ends early,
/// the film is the mean of the complete sub-frames.
RunReport render_sub_frames(FramePlans& plans, const Plan& plan, double frame, Film& film, const RunControl& control);

}  // namespace kagero
