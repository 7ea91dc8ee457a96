/// Loads the description of a scene from a scene file.
#pragma once

#include "scene/description.h"

namespace kagero {

/// The purpose for which a scene is loaded. Single rays need no camera and no film; defaults replace missing ones.
enum class SceneUse { picture, single_rays };

/// Returns the text of a scene file. Throws InputError if the file cannot be opened or is larger than 64 MiB, and
/// RunError if reading fails.
std::string scene_text(const std::string& path);

/// Reads a scene file, applies the overrides and checks the result. Throws InputError if anything is invalid. The
/// message contains file:line:column, the value, the legal range, and, for a misspelt name, the most similar legal
/// name. An animated scene has the values of `frame`, except for keys that an override sets.
SceneDescription load_scene(const std::string& path, const std::vector<Override>& overrides, const Catalogue& catalogue,
                            SceneUse use = SceneUse::picture, double frame = 0);
/// Loads a scene from text. `path` is the path of the file in messages; the file need not exist. Relative paths in the
/// scene start at the folder of `path`.
SceneDescription load_scene_text(const std::string& text, const std::string& path,
                                 const std::vector<Override>& overrides, const Catalogue& catalogue,
                                 SceneUse use = SceneUse::picture, double frame = 0);

/// Loads an animated picture again, from its text and overrides, with the values of another frame.
SceneDescription load_frame(const SceneDescription& scene, const Catalogue& catalogue, double frame);

}  // namespace kagero
