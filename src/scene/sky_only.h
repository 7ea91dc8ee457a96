/// Scenes whose pictures can be made from a map over all directions.
#pragma once

#include "scene/description.h"

namespace kagero {

/// Returns true if the picture of a scene depends only on where its rays reach the sky, as a function of their
/// directions: the scene has neither objects nor media, and all rays start at one point.
bool shows_only_sky(const SceneDescription& scene);

/// Returns the reason why shows_only_sky is false; "" if it is true.
std::string why_not_only_sky(const SceneDescription& scene);

}  // namespace kagero
