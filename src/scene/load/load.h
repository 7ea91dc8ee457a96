/// Loads the description of a scene from a scene file.
#pragma once

#include "scene/description.h"

namespace kagero {

/// The purpose for which a scene is loaded. Single rays need no camera and no film; defaults replace missing ones.
enum class SceneUse { picture, single_rays };

/// Reads a scene file, applies the overrides and checks the result. Throws InputError if anything is invalid. The
/// message contains file:line:column, the value, the legal range, and, for a misspelt name, the most similar legal
/// name.
SceneDescription load_scene(const std::string& path, const std::vector<Override>& overrides, const Catalogue& catalogue,
                            SceneUse use = SceneUse::picture);
/// Loads a scene from text. `path` is the path of the file in messages; the file need not exist. Relative paths in the
/// scene start at the folder of `path`.
SceneDescription load_scene_text(const std::string& text, const std::string& path,
                                 const std::vector<Override>& overrides, const Catalogue& catalogue,
                                 SceneUse use = SceneUse::picture);

}  // namespace kagero
