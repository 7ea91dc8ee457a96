#include "geometry/mesh_files.h"

#include "geometry/files/gltf/buffers.h"

#include <fstream>
#include <iterator>

namespace kagero {

std::vector<std::string> files_of_mesh(const std::string& path) try {
    if (!path.ends_with(".gltf") && !path.ends_with(".glb")) return {};
    MeshSource source{path, {}, {}};
    std::ifstream file(path, std::ios::binary);
    source.bytes.assign(std::istreambuf_iterator<char>(file), {});
    const GltfDocument document = parse_gltf(source);
    std::vector<std::string> files;
    for (const nlohmann::json& buffer : array_member(document, document.json, "buffers", "the file"))
        if (const auto uri = buffer.find("uri"); uri != buffer.end() && uri->is_string())
            if (const std::string text = *uri; !text.starts_with("data:"))
                files.push_back(path_of_gltf_uri(path, text));
    return files;
} catch (const InputError&) {
    return {};
}

}  // namespace kagero
