/// From a scene file to its description.
#pragma once

#include "scene/description.h"

namespace kagero {

/// Reads, overrides and checks a scene. Throws InputError naming file:line:column, the value, the legal range, and a
/// near match for a misspelt name.
SceneDescription load_scene(const std::string& path, const std::vector<Override>& overrides,
                            const Catalogue& catalogue);
/// The same for a scene that is no file; `name` stands for it in messages, relative paths in it start at the working
/// directory.
SceneDescription load_scene_text(const std::string& text, const std::string& name,
                                 const std::vector<Override>& overrides, const Catalogue& catalogue);

}  // namespace kagero
