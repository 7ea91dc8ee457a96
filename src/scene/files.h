/// The files of which a scene consists.
#pragma once

#include "scene/description.h"

#include <string>
#include <utility>
#include <vector>

namespace kagero {

/// Description and path of a file. Messages use the description, such as "--json" or "the texture of object.floor".
using NamedFile = std::pair<std::string, std::string>;

/// Returns the scene file and all files that it names: images and meshes. Some paths may be empty.
std::vector<NamedFile> files_of(const SceneDescription& scene);

}  // namespace kagero
