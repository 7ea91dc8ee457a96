#include "geometry/mesh_files.h"

#include "geometry/files/gltf/buffers.h"
#include "geometry/files/obj/mtl.h"

#include <filesystem>
#include <fstream>
#include <iterator>

namespace kagero {

namespace {

/// Adds the path of an image file.
void add_image(const std::optional<FileTexture>& texture, std::vector<std::string>& files) {
    if (texture && !texture->bytes) files.push_back(texture->path);
}

/// Returns the MTL files of an OBJ file, and their images.
std::vector<std::string> files_of_obj(const MeshSource& source) {
    MtlMaterials materials;
    std::vector<std::string> files = read_libraries(source, materials);
    for (const auto& [name, material] : materials) {
        add_image(material.color_texture, files);
        add_image(material.emission_texture, files);
    }
    std::erase_if(files, [](const std::string& file) { return !std::filesystem::is_regular_file(file); });
    return files;
}

}  // namespace

std::vector<std::string> files_of_mesh(const std::string& path) try {
    const bool is_obj = path.ends_with(".obj");
    if (!is_obj && !path.ends_with(".gltf") && !path.ends_with(".glb")) return {};
    MeshSource source{path, {}, {}};
    std::ifstream file(path, std::ios::binary);
    source.bytes.assign(std::istreambuf_iterator<char>(file), {});
    if (is_obj) return files_of_obj(source);
    const GltfDocument document = parse_gltf(source);
    std::vector<std::string> files;
    for (const char* key : {"buffers", "images"})
        for (const nlohmann::json& entry : array_member(document, document.json, key, "the file"))
            if (const auto uri = entry.find("uri"); uri != entry.end() && uri->is_string())
                if (const std::string text = *uri; !text.starts_with("data:"))
                    files.push_back(path_of_gltf_uri(path, text));
    std::erase_if(files, [](const std::string& name) { return !std::filesystem::is_regular_file(name); });
    return files;
} catch (const InputError&) {
    return {};
}

}  // namespace kagero
