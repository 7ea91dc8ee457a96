/// Writes the description of a scene as a scene file.
#pragma once

#include "scene/description.h"

namespace kagero {

/// Returns the whole scene as TOML text, including defaults. Loading the text again gives the same description.
std::string print_scene(const SceneDescription& scene);

}  // namespace kagero
