/// Loads the keys of an object that state how its surface sends light on: `material` and the keys that belong to it.
#pragma once

#include "scene/reader.h"

namespace kagero {

/// Returns the names of these keys.
const std::vector<std::string>& material_keys();

/// Loads these keys. `media` contains "space" and the names of the media. `object.shape` and `object.shading` are
/// already loaded. Throws InputError if a key does not belong to the material, or if the material does not suit the
/// shape.
void load_material(const Section& section, const std::vector<std::string>& media, ObjectDescription& object);

/// Throws InputError if a colour of a diffuse object exceeds 1. Its faces are already loaded.
void check_albedo(const Section& section, const ObjectDescription& object);

/// Throws InputError if the camera is a falling observer and the scene uses a medium that is not a spacetime.
void check_falling_camera(const SceneDescription& scene, const Catalogue& catalogue);

}  // namespace kagero
