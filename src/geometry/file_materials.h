/// Division of meshes into parts with the materials of their files.
#pragma once

#include "scene/description.h"

namespace kagero {

/// Replaces each object with materials = "file" by one object for each material of its file, with the paints and the
/// material that the file states. A metallic surface becomes a mirror, and an unlit one a surface that has its colour;
/// the others are diffuse. Also sets ObjectDescription::scene_index of all objects. Objects that are already parts do
/// not change. `earlier` is the divided scene of another frame of the same animation, or null; its mesh files are used
/// again. Throws InputError if a file or a material cannot be read.
void divide_by_material(SceneDescription& scene, const SceneDescription* earlier);

}  // namespace kagero
