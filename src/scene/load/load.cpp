#include "scene/load/load.h"

#include "animation/animation.h"
#include "scene/load/load_formula.h"
#include "scene/load/load_integrator.h"
#include "scene/load/load_material.h"
#include "scene/load/load_objects.h"
#include "scene/load/load_space.h"
#include "scene/overrides.h"
#include "scene/toml.h"
#include "scene/vector3.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string_view>

namespace kagero {

namespace {

/// Throws InputError if the viewing direction of the camera is zero, or if `up` is zero or parallel to it.
void check_view(const Section& section, const CameraDescription& camera) {
    const Value& look_at = require(section, "look_at");
    const Double3 forward = subtract(camera.look_at, camera.position);
    if (length(forward) == 0) fail(look_at, full_name(section, "look_at"), "a point other than camera.position");
    const Value* up = find(section, "up");
    if (length(camera.up) == 0) fail(up ? *up : look_at, full_name(section, "up"), "a vector that is not zero");
    // If the sine of the angle between the vectors is below √ε, half of the digits of the cross product are lost.
    const double sine = length(cross(unit(forward), unit(camera.up)));
    if (sine > std::sqrt(std::numeric_limits<double>::epsilon())) return;
    throw InputError(up ? up->location : look_at.location,
                     "camera.up = " + to_toml(camera.up) + (up ? "" : " (the default)") +
                         " is parallel to the viewing direction; choose another camera.up");
}

/// Adds the keys of [camera] and [film] that a picture requires, where they are missing.
void add_default_view(Value& root, const SceneDescription& scene) {
    Double3 position = scene.space.center;
    position[0] -= 0.1 * scene.integrator.escape_radius;
    const auto add = [&](const char* table, const char* key, const std::string& value) {
        const Value* keys = find({&root, "", root.location}, table);
        if (!keys || (keys->kind == Value::Kind::table && !find({keys, table, keys->location}, key)))
            apply_override(root, std::string(table) + "." + key + "=" + value, "the default view");
    };
    add("camera", "position", to_toml(position));
    add("camera", "look_at", to_toml(scene.space.center));
    add("film", "size", "[640, 480]");
}

/// Reads the keys that state the motion of the camera: `observer` or `velocity`.
void load_motion(const Section& section, SpaceDescription& space, CameraDescription& camera) {
    const Value *observer = find(section, "observer"), *velocity = find(section, "velocity");
    if (observer && velocity)
        throw InputError(velocity->key_location, "camera.velocity = " + to_toml(*velocity) + " and camera.observer = " +
                                                     to_toml(*observer) + " exclude each other; remove one of them");
    camera.velocity = load_velocity(section, "velocity", space);
    if (!observer) return;
    camera.observer = static_cast<ObserverKind>(to_choice(*observer, "camera.observer", observer_names()));
    camera.observer_location = observer->location;
}

/// Reads the key `medium` of the camera.
void load_camera_medium(const Section& section, const std::vector<MediumDescription>& media,
                        CameraDescription& camera) {
    const Value* medium = find(section, "medium");
    if (!medium) return;
    std::vector<std::string> names = names_of_media(media);
    names.emplace_back("auto");
    const std::size_t choice = to_choice(*medium, "camera.medium", names);
    camera.medium = names[choice];
    camera.medium_location = medium->location;
    if (choice <= media.size()) camera.medium_index = static_cast<std::uint32_t>(choice);
}

/// Reads the keys of a thin lens.
void load_lens(const Section& section, CameraDescription& camera) {
    read(section, "aperture_radius", camera.aperture_radius, {0, 1e12});
    camera.focus_distance = length(subtract(camera.look_at, camera.position));
    read(section, "focus_distance", camera.focus_distance, positive_length);
    camera.states_focus_distance = find(section, "focus_distance");
    const Value* aperture = find(section, "aperture_radius");
    if (!aperture) return;
    camera.aperture_location = aperture->location;
    if (camera.aperture_radius > 0 && camera.type != CameraType::perspective)
        throw InputError(aperture->location, "camera.aperture_radius = " + to_toml(camera.aperture_radius) +
                                                 " is legal only with a perspective camera, but camera.type is \"" +
                                                 name_of(camera.type) + "\"; state 0, or another type");
}

/// Throws InputError if the film has a layer that the materials of the scene exclude.
void check_layers_and_materials(const Section& film, const SceneDescription& scene) {
    const Value* layers = find(film, "layers");
    if (!layers || !has_material(scene, Material::diffuse)) return;
    for (const Value& layer : layers->items)
        if (layer.string == "position_error" || layer.string == "rounding_error")
            throw InputError(layer.location, "the layer \"" + layer.string +
                                                 "\" of film.layers is not legal in a scene with material = "
                                                 "\"diffuse\": it compares the ends of rays, and a diffuse surface "
                                                 "sends them into random directions; remove the layer. The layer "
                                                 "\"standard_error\" states the error of the colour that the random "
                                                 "directions cause");
}

/// Loads the table [camera]. The view is checked only for pictures.
CameraDescription load_camera(const Section& section, SpaceDescription& space,
                              const std::vector<MediumDescription>& media, SceneUse use) {
    CameraDescription camera;
    std::vector<std::string> keys{"type",    "position",        "look_at",       "up",
                                  "fov",     "observer",        "velocity",      "medium",
                                  "shutter", "aperture_radius", "focus_distance"};
    if (const Value* type = find(section, "type")) {
        camera.type = static_cast<CameraType>(to_choice(*type, "camera.type", camera_type_names()));
    }
    if (camera.type == CameraType::orthographic) keys.emplace_back("height");
    check_keys(section, keys);
    load_motion(section, space, camera);
    load_camera_medium(section, media, camera);
    const Value& position = require(section, "position");
    camera.position = to_double3(position, "camera.position", any_length);
    camera.position_location = position.location;
    camera.look_at = to_double3(require(section, "look_at"), "camera.look_at", any_length);
    read(section, "up", camera.up, any_length);
    read(section, "fov", camera.fov, {0, 180, true, true});
    if (const Value* fov = find(section, "fov")) camera.fov_location = fov->location;
    read(section, "height", camera.height, positive_length);
    read(section, "shutter", camera.shutter, {0, 1});
    load_lens(section, camera);
    if (use == SceneUse::picture) check_view(section, camera);
    return camera;
}

FilmDescription load_film(const Section& section, const std::vector<std::string>& layers) {
    check_keys(section, {"size", "spp", "seed", "layers", "max_bounces", "exposure", "tone", "sampling",
                         "max_interpolation_error"});
    FilmDescription film;
    const Value& size = require(section, "size");
    if (size.kind != Value::Kind::array || size.items.size() != 2) fail(size, "film.size", "an array [width, height]");
    film.width = to_count(size.items[0], "film.size[0]", 1, 65536);
    film.height = to_count(size.items[1], "film.size[1]", 1, 65536);
    if (const Value* spp = find(section, "spp")) film.spp = to_count(*spp, "film.spp", 1, 65536);
    if (const Value* seed = find(section, "seed")) {
        film.seed = to_count(*seed, "film.seed", 0, std::numeric_limits<std::uint32_t>::max());
    }
    if (const Value* bounces = find(section, "max_bounces"))
        film.max_bounces = to_count(*bounces, "film.max_bounces", 0, 1000);
    read(section, "exposure", film.tone.exposure, {-max_exposure, max_exposure});
    if (const Value* tone = find(section, "tone"))
        film.tone.curve = static_cast<ToneCurve>(to_choice(*tone, "film.tone", tone_curve_names()));
    if (const Value* sampling = find(section, "sampling"))
        film.sampling = static_cast<Sampling>(to_choice(*sampling, "film.sampling", sampling_names()));
    read(section, "max_interpolation_error", film.max_interpolation_error, {1e-6, 100});
    if (const Value* chosen = find(section, "layers")) {
        if (chosen->kind != Value::Kind::array || chosen->items.empty())
            fail(*chosen, "film.layers", "an array of layer names");
        film.layers.clear();
        for (const Value& layer : chosen->items) {
            const std::string& name = layers[to_choice(layer, "film.layers", layers)];
            for (const std::string& other : film.layers) {
                if (other == name) fail(layer, "film.layers", "listed only once");
            }
            film.layers.push_back(name);
        }
    }
    return film;
}

SkyDescription load_sky(const Section& section, const std::string& directory) {
    std::vector<std::string> keys{"color", "texture", "checker", "pole"};
    if (section.name == "sky") keys.emplace_back("far");
    check_keys(section, keys);
    SkyDescription sky;
    sky.paint = load_paint(section, sky.paint, CheckerKey::flag, directory);
    read(section, "pole", sky.pole, any_length);
    if (length(sky.pole) == 0) fail(require(section, "pole"), full_name(section, "pole"), "a vector that is not zero");
    return sky;
}

SkyDescription load_far_sky(const Section& sky, const SpaceDescription& space, const std::string& directory) {
    const Value* far = find(sky, "far");
    if (!far) return {};
    if (far->kind != Value::Kind::table) fail(*far, "sky.far", "a table: [sky.far]");
    if (!space.has_second_sheet)
        throw InputError(far->location,
                         "sky.far is not legal: the space " + to_toml(space.hamiltonian) + " has only one sky; " +
                             (space.formula ? "state space.far_domain, or " : "") + "remove the table [sky.far]");
    return load_sky({far, "sky.far", far->location}, directory);
}

/// The overrides of a scene, with the paths of their keys.
class ParsedOverrides {
public:
    explicit ParsedOverrides(const std::vector<Override>& overrides) : overrides_(overrides) {
        for (const Override& entry : overrides) paths_.push_back(keys_of_path(entry.text, {option_of(entry), 0, 0}));
    }
    /// Applies the overrides of the table [animation], or all others.
    void apply(Value& root, bool to_animation) const {
        for (std::size_t i = 0; i < overrides_.size(); ++i)
            if ((paths_[i].front() == "animation") == to_animation)
                apply_override(root, overrides_[i].text, option_of(overrides_[i]));
    }
    const std::vector<std::vector<std::string>>& paths() const { return paths_; }

private:
    static std::string option_of(const Override& entry) {
        return entry.option.empty() ? "-D " + entry.text : entry.option;
    }

    const std::vector<Override>& overrides_;
    std::vector<std::vector<std::string>> paths_;
};

/// Reads all tables of a document, except [animation].
void load_tables(const Value& root, const Catalogue& catalogue, SceneUse use, SceneDescription& scene) {
    check_keys({&root, "", root.location},
               {"space", "medium", "integrator", "camera", "film", "sky", "object", "animation"});
    const std::string directory = std::filesystem::path(scene.path).parent_path().string();
    scene.space = load_space(section(root, "space"), catalogue, SpaceTable::space);
    scene.integrator = load_integrator(section(root, "integrator"), scene.space, catalogue);
    scene.media = load_media(root, scene, catalogue);
    Value with_view = root;
    if (use == SceneUse::single_rays) add_default_view(with_view, scene);
    scene.camera = load_camera(section(with_view, "camera"), scene.space, scene.media, use);
    scene.film = load_film(section(with_view, "film"), catalogue.layers);
    const Section sky = section(root, "sky");
    scene.sky = load_sky(sky, directory);
    scene.far_sky = load_far_sky(sky, scene.space, directory);
    scene.objects = load_objects(root, directory, scene.space, scene.media);
    check_falling_camera(scene, catalogue);
    check_layers_and_materials(section(with_view, "film"), scene);
}

}  // namespace

std::string scene_text(const std::string& path) {
    // The size limit bounds the memory for files that never end, such as /dev/zero.
    constexpr std::size_t max_size = std::size_t{64} << 20;
    std::error_code error;
    if (std::filesystem::is_directory(path, error))
        throw InputError({path, 0, 0}, "this is a directory, not a scene file; name a .toml file");
    std::ifstream file(path, std::ios::binary);
    if (!file) throw InputError({path, 0, 0}, std::string("this scene file cannot be opened: ") + std::strerror(errno));
    std::string text;
    char buffer[1 << 16];
    while (file.read(buffer, sizeof buffer), file.gcount() > 0) {
        text.append(buffer, static_cast<std::size_t>(file.gcount()));
        if (text.size() > max_size)
            throw InputError({path, 0, 0}, "this file is larger than 64 MiB, the limit for scene files");
    }
    if (file.bad()) throw RunError("reading '" + path + "' failed before the end of the file");
    return text;
}

SceneDescription load_scene(const std::string& path, const std::vector<Override>& overrides, const Catalogue& catalogue,
                            SceneUse use, double frame) {
    return load_scene_text(scene_text(path), path, overrides, catalogue, use, frame);
}

SceneDescription load_scene_text(const std::string& text, const std::string& path,
                                 const std::vector<Override>& overrides, const Catalogue& catalogue, SceneUse use,
                                 double frame) {
    SceneDescription scene;
    scene.path = path;
    scene.text = text;
    for (const Override& entry : overrides) scene.overrides.push_back(entry.text);
    Value root = parse_toml(scene.text, path);
    root.location = {path, 1, 1};
    const ParsedOverrides parsed(overrides);
    parsed.apply(root, true);
    scene.animation = load_animation(root);
    if (scene.animation)
        for (const auto& key : parsed.paths()) fix_key(*scene.animation, key);
    try {
        if (scene.animation) set_frame(root, *scene.animation, frame);
        parsed.apply(root, false);
        load_tables(root, catalogue, use, scene);
    } catch (const InputError& error) {  // the values of the frame may be the reason
        if (scene.animation && !scene.animation->keys.empty()) throw in_frame(error, frame);
        throw;
    }
    return scene;
}

SceneDescription load_frame(const SceneDescription& scene, const Catalogue& catalogue, double frame) {
    return load_scene_text(scene.text, scene.path, {scene.overrides.begin(), scene.overrides.end()}, catalogue,
                           SceneUse::picture, frame);
}

}  // namespace kagero
