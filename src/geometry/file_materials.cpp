#include "geometry/file_materials.h"

#include "film/read_image.h"
#include "geometry/mesh.h"
#include "scene/value.h"

#include <algorithm>

namespace kagero {

namespace {

/// Returns the paint of a material's colour or emission.
Paint paint_of(const ObjectDescription& object, const FileMaterial& material, const Double3& color,
               const std::optional<FileTexture>& texture) {
    Paint paint;
    paint.color = color;
    paint.location = object.file_location;
    paint.user = material.name + " of " + object.file;
    if (!texture) return paint;
    paint.kind = Paint::Kind::texture;
    paint.texture = texture->path;
    paint.image = texture->bytes;
    paint.factor = color;
    paint.along_u = texture->along_u;
    paint.along_v = texture->along_v;
    return paint;
}

/// Returns the mean of the blue channel of an image that is not sRGB-encoded, as it is stored, from 0 to 1.
double mean_blue(const StoredImage& image) {
    const std::size_t pixels = std::size_t(image.width) * std::size_t(image.height);
    const auto mean = [&](const auto& components, double greatest) {
        double sum = 0;
        for (std::size_t i = 0; i < pixels; ++i) sum += double(components[3 * i + 2]);
        return sum / greatest / double(pixels);
    };
    if (const auto* floats = std::get_if<0>(&image.rgb)) return mean(*floats, 1);
    if (const auto* bytes = std::get_if<1>(&image.rgb)) return mean(bytes->codes, 255);
    return mean(std::get<2>(image.rgb).codes, 65535);
}

/// Returns the metallic share of a material, with the mean of its texture. Adds a remark if the share varies, or if it
/// is neither 0 nor 1.
double metallic_share(const ObjectDescription& object, const FileMaterial& material, FileMesh& mesh) {
    double share = material.metallic;
    if (material.metallic_texture) {
        const FileTexture& texture = *material.metallic_texture;
        share *= mean_blue(read_image({texture.path, texture.bytes.get(), material.name + " of " + object.file},
                                      object.file_location));
    }
    if (share > 0 && share < 1)
        mesh.remarks.push_back(material.name + " is metallic by " + to_toml(share) +
                               (material.metallic_texture ? " in the mean" : "") + ", so it is " +
                               (share < 0.5 ? "diffuse" : "a mirror"));
    return share;
}

/// Sets the material and the paints of a part.
void set_material(const FileMaterial& material, ObjectDescription& part) {
    part.paint = paint_of(part, material, material.color, material.color_texture);
    part.faces.fill(part.paint);
    if (part.states_material) return;
    part.material = material.is_unlit         ? Material::surface
                    : material.metallic < 0.5 ? Material::diffuse
                                              : Material::mirror;
    if (part.material != Material::surface)
        part.emission = paint_of(part, material, material.emission, material.emission_texture);
}

/// Returns the content of the mesh file of an object.
std::shared_ptr<const FileMesh> content_of(const ObjectDescription& object, const SceneDescription* earlier) {
    if (earlier)
        for (const ObjectDescription& part : earlier->objects)
            if (part.part && part.file == object.file) return part.part->file;
    auto mesh = std::make_shared<FileMesh>(read_mesh_file(object));
    for (FileMaterial& material : mesh->materials) {
        material.metallic = metallic_share(object, material, *mesh);
        if (object.states_material && std::ranges::max(material.emission) > 0)
            mesh->remarks.push_back(material.name + " emits light, which is left out with material = \"surface\"");
    }
    if (mesh->triangles.empty())
        throw InputError(object.file_location, "object." + object.name + ".file = \"" + object.file +
                                                   "\": the file has no triangle with a nonzero area");
    return mesh;
}

}  // namespace

void divide_by_material(SceneDescription& scene, const SceneDescription* earlier) {
    std::vector<ObjectDescription> objects;
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        ObjectDescription& object = scene.objects[i];
        if (object.part) {
            objects.push_back(object);
            continue;
        }
        object.scene_index = std::uint32_t(i);
        if (!object.has_file_materials) {
            objects.push_back(std::move(object));
            continue;
        }
        const std::shared_ptr<const FileMesh> mesh = content_of(object, earlier);
        for (std::uint32_t k = 0; k < mesh->materials.size(); ++k) {
            if (!std::ranges::count(mesh->material_of_triangle, k)) continue;
            ObjectDescription part = object;
            part.part = MeshPart{mesh, k};
            set_material(mesh->materials[k], part);
            objects.push_back(std::move(part));
        }
    }
    scene.objects = std::move(objects);
}

}  // namespace kagero
