/// A description back to a scene file.
#pragma once

#include "scene/description.h"

namespace kagero {

/// The scene written back whole as TOML, defaults included; loading it again gives the same description.
std::string print_scene(const SceneDescription& scene);

}  // namespace kagero
