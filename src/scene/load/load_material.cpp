#include "scene/load/load_material.h"

#include <algorithm>

namespace kagero {
namespace {

/// Legal range of a tint: a surface that only sends light on cannot amplify it.
constexpr Range tint_range{0, 1};

/// Returns the index of the medium in an optional key, or `fallback` if the key is missing. Sets `location` to the
/// position of the value if the key is stated.
std::uint32_t load_medium_index(const Section& section, const std::string& key, const std::vector<std::string>& media,
                                std::uint32_t fallback, FileLocation& location) {
    const Value* value = find(section, key);
    if (!value) return fallback;
    location = value->location;
    return static_cast<std::uint32_t>(to_choice(*value, full_name(section, key), media));
}

/// Throws InputError if a key is stated that only other materials have.
void refuse_keys_of_other_materials(const Section& section, const ObjectDescription& object) {
    const auto refuse = [&](const std::string& key, const std::string& legal) {
        if (const Value* value = find(section, key))
            throw InputError(value->key_location, full_name(section, key) + " is legal only with " + legal +
                                                      "; state the material, or remove the key");
    };
    if (object.material == Material::surface || object.material == Material::diffuse)
        refuse("tint", "material = \"mirror\" or \"boundary\"");
    if (object.material != Material::diffuse) refuse("emission_strength", "material = \"diffuse\"");
    if (object.material == Material::boundary) return;
    for (const char* key : {"interior", "exterior", "fresnel"}) refuse(key, "material = \"boundary\"");
}

/// Loads the key `materials` of a mesh. With "file", the scene states no paint, and no material except "surface".
void load_file_materials(const Section& section, ObjectDescription& object) {
    const Value* value = find(section, "materials");
    if (!value) return;
    const std::string name = full_name(section, "materials");
    object.has_file_materials = to_choice(*value, name, {"scene", "file"}) == 1;
    if (!object.has_file_materials) return;
    for (const char* key :
         {"color", "texture", "checker", "interior", "exterior", "fresnel", "tint", "emission_strength"})
        if (const Value* other = find(section, key))
            throw InputError(other->key_location, full_name(section, key) +
                                                      " is not legal with materials = \"file\", "
                                                      "which takes it from the mesh file; remove one of the two keys");
    object.states_material = find(section, "material") != nullptr;
    if (object.material != Material::surface)
        throw InputError(object.material_location,
                         full_name(section, "material") + " = " +
                             to_toml(material_names()[std::size_t(object.material)]) +
                             " is not legal with materials = \"file\", which takes the material from the mesh file; "
                             "remove one of the two keys, or state \"surface\" for the colours of the file alone");
    if (object.shading == Shading::lambert && !object.states_material)
        throw InputError(require(section, "shading").location,
                         full_name(section, "shading") +
                             " = \"lambert\" is legal with materials = \"file\" only if "
                             "material = \"surface\" is stated too; state it, or remove "
                             "shading");
}

/// Throws InputError for keys that a diffuse surface does not have. It is at rest, and its light is that of other
/// surfaces and the sky, or emission_strength times its colour.
void refuse_keys_beside_diffuse(const Section& section, const ObjectDescription& object) {
    if (object.shading != Shading::emission)
        throw InputError(require(section, "shading").location,
                         full_name(section, "shading") +
                             " = \"lambert\" is not legal with material = \"diffuse\", which is lit by the objects and "
                             "the sky of the scene; remove one of the two keys");
    for (const char* key : {"temperature", "velocity"})
        if (const Value* value = find(section, key))
            throw InputError(value->key_location, full_name(section, key) +
                                                      " is not legal with material = \"diffuse\", which is at rest and "
                                                      "emits emission_strength times its color; remove the key");
}

/// Throws InputError if a mirror or boundary states its light, as a surface does.
void refuse_keys_of_surfaces(const Section& section, const ObjectDescription& object) {
    const std::string material = "material = " + to_toml(material_names()[std::size_t(object.material)]);
    for (const char* key : {"color", "texture", "checker", "temperature", "faces"})
        if (const Value* value = find(section, key))
            throw InputError(value->key_location, full_name(section, key) + " is not legal with " + material +
                                                      ", which sends light on and emits none; to color this light, "
                                                      "state tint = [r, g, b] instead");
    if (const Value* velocity = find(section, "velocity"))
        throw InputError(velocity->key_location, full_name(section, "velocity") + " is not legal with " + material +
                                                     ", which is at rest; remove the key");
    if (object.shading != Shading::emission)
        throw InputError(require(section, "shading").location,
                         full_name(section, "shading") + " = \"lambert\" is not legal with " + material +
                             ": it lights the color of the object, which is legal only for a \"surface\"; remove one "
                             "of the two keys");
}

/// Loads the media of a boundary.
void load_boundary(const Section& section, const std::vector<std::string>& media, ObjectDescription& object) {
    const bool is_closed = object.shape == Shape::box || object.shape == Shape::room || object.shape == Shape::sphere ||
                           object.shape == Shape::mesh;
    if (!is_closed)
        fail(require(section, "material"), full_name(section, "material"),
             "\"surface\" or \"mirror\", because a " + shape_names()[std::size_t(object.shape)] +
                 " has no interior; a boundary is a box, room, sphere or closed mesh");
    if (!find(section, "interior"))
        throw InputError(object.material_location,
                         "the required key " + full_name(section, "interior") +
                             " is missing: a boundary needs the name of the medium inside it" + suggestion("", media));
    if (object.interior != object.exterior) return;
    throw InputError(object.interior_location, full_name(section, "interior") + " = " +
                                                   to_toml(media[object.interior]) + " is the same medium as " +
                                                   full_name(section, "exterior") +
                                                   (find(section, "exterior") ? "" : ", whose default is \"space\"") +
                                                   "; a boundary separates two media, so change one of them");
}

/// Returns true if the level of H scales with the momentum, as for light in a spacetime.
bool is_spacetime(const SpaceDescription& space, const Catalogue& catalogue) {
    return space.formula ? space.formula->parsed.pt != 0 : catalogue.hamiltonian_named(space.hamiltonian)->spacetime;
}

}  // namespace

const std::vector<std::string>& material_keys() {
    static const std::vector<std::string> keys{"material", "interior", "exterior",
                                               "fresnel",  "tint",     "emission_strength"};
    return keys;
}

void load_material(const Section& section, const std::vector<std::string>& media, ObjectDescription& object) {
    object.material_location = object.interior_location = object.exterior_location = object.location;
    if (const Value* material = find(section, "material")) {
        const std::size_t choice = to_choice(*material, full_name(section, "material"), material_names());
        object.material = static_cast<Material>(choice);
        object.material_location = material->location;
    }
    object.interior = load_medium_index(section, "interior", media, 0, object.interior_location);
    object.exterior = load_medium_index(section, "exterior", media, 0, object.exterior_location);
    if (const Value* fresnel = find(section, "fresnel")) {
        const std::size_t choice = to_choice(*fresnel, full_name(section, "fresnel"), fresnel_names());
        object.fresnel = static_cast<Fresnel>(choice);
    }
    read(section, "tint", object.tint, tint_range);
    read(section, "emission_strength", object.emission_strength, {0, 1e6});
    load_file_materials(section, object);
    refuse_keys_of_other_materials(section, object);
    if (object.material == Material::diffuse) refuse_keys_beside_diffuse(section, object);
    else if (object.material != Material::surface) refuse_keys_of_surfaces(section, object);
    if (object.material == Material::boundary) load_boundary(section, media, object);
}

void check_albedo(const Section& section, const ObjectDescription& object) {
    if (object.material != Material::diffuse) return;
    std::vector<const Paint*> paints{&object.paint};
    for (const Paint& face : object.faces) paints.push_back(&face);
    for (const Paint* paint : paints) {
        if (paint->kind == Paint::Kind::texture || std::ranges::max(paint->color) <= 1) continue;
        throw InputError(paint->location, "the color " + to_toml(paint->color) + " of " + section.name +
                                              " is not legal with material = \"diffuse\": it is the albedo, the share "
                                              "of the light that the surface scatters, so the legal range of each "
                                              "number is 0 <= value <= 1; a surface emits light with "
                                              "emission_strength > 0");
    }
}

void check_falling_camera(const SceneDescription& scene, const Catalogue& catalogue) {
    if (scene.camera.observer != ObserverKind::falling || scene.camera.velocity) return;
    for (std::uint32_t i = 1; i <= scene.media.size(); ++i) {
        const MediumDescription& medium = scene.media[i - 1];
        if (!uses_medium(scene, i) || is_spacetime(medium.space, catalogue)) continue;
        throw InputError(*scene.camera.observer_location,
                         "camera.observer = \"falling\" is not legal together with the medium " + to_toml(medium.name) +
                             " (line " + std::to_string(medium.location.line) + "), whose Hamiltonian " +
                             to_toml(medium.space.hamiltonian) +
                             " is not a spacetime: its rays have one level of H, but those of a falling observer have "
                             "different frequencies; choose another observer, or a spacetime for the medium");
    }
}

}  // namespace kagero
