#include "scene/description.h"

#include <algorithm>

namespace kagero {

const std::vector<std::string>& refill_names() {
    static const std::vector<std::string> names{"auto", "on", "off"};
    return names;
}

const std::vector<std::string>& observer_names() {
    static const std::vector<std::string> names{"static", "zamo", "falling", "coordinate"};
    return names;
}

const std::vector<std::string>& camera_type_names() {
    static const std::vector<std::string> names{"perspective", "equirectangular", "orthographic"};
    return names;
}

const std::vector<std::string>& shape_names() {
    static const std::vector<std::string> names{"rectangle", "box", "room", "sphere", "mesh", "disk"};
    return names;
}

const std::vector<std::string>& face_names() {
    static const std::vector<std::string> names{"px", "nx", "py", "ny", "pz", "nz"};
    return names;
}

const std::vector<std::string>& material_names() {
    static const std::vector<std::string> names{"surface", "mirror", "boundary", "diffuse"};
    return names;
}

const std::vector<std::string>& fresnel_names() {
    static const std::vector<std::string> names{"auto", "transmit", "none"};
    return names;
}

const std::string& name_of_medium(const SceneDescription& scene, std::uint32_t index) {
    static const std::string space = "space";
    return index == 0 ? space : scene.media[index - 1].name;
}

bool has_material(const SceneDescription& scene, Material material) {
    return std::any_of(scene.objects.begin(), scene.objects.end(), [&](const ObjectDescription& object) {
        const bool is_open = object.has_file_materials && !object.states_material && !object.part;
        return object.material == material ||
               (is_open && (material == Material::diffuse || material == Material::mirror));
    });
}

bool uses_medium(const SceneDescription& scene, std::uint32_t index) {
    if (scene.camera.medium_index == index) return true;
    return std::any_of(scene.objects.begin(), scene.objects.end(), [&](const ObjectDescription& object) {
        return object.material == Material::boundary && (object.interior == index || object.exterior == index);
    });
}

const HamiltonianInfo* Catalogue::hamiltonian_named(const std::string& name) const {
    for (std::uint32_t i = 0; i < hamiltonian_count; ++i)
        if (name == hamiltonians[i].name) return &hamiltonians[i];
    return nullptr;
}

}  // namespace kagero
