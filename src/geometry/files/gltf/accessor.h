/// Arrays of numbers in glTF files.
#pragma once

#include "geometry/files/gltf/buffers.h"

namespace kagero {

/// What an accessor must contain for its use.
enum class GltfUse { positions, normals, texture_coordinates, indices };

/// Returns the numbers of an accessor: three per position and normal, two per pair of texture coordinates, one per
/// index. Normalized integers are converted to −1 to 1 or 0 to 1. `name` is the position of the value in the file.
/// Throws InputError if the accessor has another type, or if its buffer does not contain it.
std::vector<double> read_accessor(const GltfDocument& document, GltfBuffers& buffers, const nlohmann::json& value,
                                  GltfUse use, const std::string& name);

}  // namespace kagero
