/// Writes the description of a scene as a scene file.
#pragma once

#include "scene/description.h"

namespace kagero {

/// Returns the whole scene as TOML text, including defaults. Loading the text again gives the same description.
std::string print_scene(const SceneDescription& scene);

/// Returns the tables of all objects. Objects with the same text have the same surfaces and paints.
std::string print_surfaces(const SceneDescription& scene);
/// Returns the tables of all skies.
std::string print_skies(const SceneDescription& scene);

}  // namespace kagero
