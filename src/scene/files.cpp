#include "scene/files.h"

namespace kagero {
namespace {

void add_texture(const Paint& paint, const std::string& name, std::vector<NamedFile>& files) {
    if (!paint.texture.empty() && !paint.image) files.emplace_back("the texture of " + name, paint.texture);
}

}  // namespace

std::vector<NamedFile> files_of(const SceneDescription& scene) {
    std::vector<NamedFile> files{{"the scene", scene.path}};
    add_texture(scene.sky.paint, "sky", files);
    add_texture(scene.far_sky.paint, "sky.far", files);
    for (const ObjectDescription& object : scene.objects) {
        const std::string name = "object." + object.name;
        add_texture(object.paint, name, files);
        for (const Paint& face : object.faces) add_texture(face, name, files);
        if (object.emission) add_texture(*object.emission, name, files);
        files.emplace_back("the mesh of " + name, object.file);
    }
    return files;
}

}  // namespace kagero
