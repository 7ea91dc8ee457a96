/// The table [animation] of a scene: keys whose values are expressions of the frame.
#pragma once

#include "scene/description.h"
#include "scene/value.h"

#include <optional>

namespace kagero {

/// Greatest number of frames of an animation.
inline constexpr std::uint32_t max_frames = 1u << 31;

/// Reads the table [animation] of a document; nullopt if it has none. Throws InputError if the table states anything
/// illegal, except the values of expressions, which depend on the frame.
std::optional<AnimationDescription> load_animation(const Value& root);

/// Removes the animated keys that an override sets too, so that the override determines them. `path` is the path of the
/// override.
void fix_key(AnimationDescription& animation, const std::vector<std::string>& path);

/// Sets all animated keys in the document to their values in a frame. A fraction of a frame is legal. The expressions
/// may contain frame, u = frame/frames, w = frame/(frames − 1), which is 0 for a single frame, and s = frame/fps. Sets
/// `animation.frame` and `animation.values`. Throws InputError if a value is not a finite number.
void set_frame(Value& root, AnimationDescription& animation, double frame);

/// Returns an error with the number of the frame in which it occurred.
InputError in_frame(const InputError& error, double frame);

}  // namespace kagero
