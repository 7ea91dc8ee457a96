/// Materials of glTF files.
#pragma once

#include "geometry/files/file_material.h"
#include "geometry/files/gltf/buffers.h"

namespace kagero {

/// Returns an entry of the array `materials`: base colour, emission and metallic with their textures, and whether it is
/// unlit (KHR_materials_unlit). The diffuse colour of a material with specular colour and glossiness is its base
/// colour. Throws InputError with the name of the material if a value is not legal, or if its textures use different
/// coordinates.
FileMaterial read_gltf_material(const GltfDocument& document, GltfBuffers& buffers, std::uint64_t index);

/// Returns the material of a primitive that states none.
FileMaterial default_gltf_material();

}  // namespace kagero
