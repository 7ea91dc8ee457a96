#include "view/view_state.h"

#include "film/film.h"
#include "report/json.h"
#include "scene/value.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

constexpr std::size_t max_keys = 128, max_text = 4000, max_tab = 40;

/// Keys that a page may set in every scene.
constexpr const char* common_keys[] = {"camera.position", "camera.look_at",
                                       "camera.up",       "camera.fov",
                                       "camera.observer", "film.exposure",
                                       "film.tone",       "sky.pole",
                                       "sky.color",       "integrator.max_pixel_error"};
/// Those of them, and no others, that keep the rays from a position.
constexpr const char* ray_keeping_keys[] = {"camera.look_at", "camera.up", "camera.fov", "film.exposure", "film.tone",
                                            "film.layers",    "film.size", "sky.pole",   "sky.color"};
/// Keys of a formula.
constexpr const char* formula_keys[] = {"space.H", "space.H0", "space.domain", "space.capture", "space.length_scale"};

template <std::size_t n>
bool contains(const char* const (&keys)[n], const std::string& key) {
    return std::find(std::begin(keys), std::end(keys), key) != std::end(keys);
}

bool is_identifier(const std::string& name) {
    const auto is_word = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    };
    return !name.empty() && name.size() <= max_tab && std::all_of(name.begin(), name.end(), is_word) &&
           !(name[0] >= '0' && name[0] <= '9');
}

/// Returns the value of a key as TOML: a number, a text, or three numbers.
std::string toml_of(const std::string& key, const Json& value) {
    const auto finite = [&](const Json& number) {
        if (!number.is_number() || !std::isfinite(number.get<double>()))
            throw InputError(key + ": " + text_of(number) + " is not a finite number");
        return number.get<double>();
    };
    if (value.is_number()) return to_toml(finite(value));
    if (value.is_string()) {
        const auto text = value.get<std::string>();
        if (text.size() > max_text)
            throw InputError(key + ": the text has " + std::to_string(text.size()) + " characters; at most " +
                             std::to_string(max_text) + " are permitted");
        return to_toml(text);
    }
    if (!value.is_array() || value.size() != 3)
        throw InputError(key + ": the value must be a number, a text, or three numbers");
    return to_toml(Double3{finite(value[0]), finite(value[1]), finite(value[2])});
}

/// Returns a whole number of the request; `fallback` if it is missing.
std::uint32_t whole_number(const Json& request, const char* name, std::uint32_t fallback, std::uint32_t least,
                           std::uint32_t greatest) {
    if (!request.contains(name)) return fallback;
    const Json& value = request[name];
    if (!value.is_number_unsigned() || value.get<std::uint64_t>() < least || value.get<std::uint64_t>() > greatest)
        throw InputError(std::string(name) + ": the value must be a whole number from " + std::to_string(least) +
                         " to " + std::to_string(greatest));
    return value.get<std::uint32_t>();
}

std::string word(const Json& request, const char* name, const std::string& fallback) {
    if (!request.contains(name)) return fallback;
    if (!request[name].is_string()) throw InputError(std::string(name) + ": the value must be a text");
    return request[name].get<std::string>();
}

Quality quality_named(const std::string& name) {
    if (name == "moving") return Quality::moving;
    if (name == "full") return Quality::full;
    if (name == "fine") return Quality::fine;
    throw InputError("quality: \"" + name.substr(0, max_tab) + "\" is not one of moving, full, fine");
}

void read_keys(const Json& keys, const SceneDescription& scene, ViewState& state) {
    if (!keys.is_object()) throw InputError("keys: the value must be an object");
    if (keys.size() > max_keys)
        throw InputError("keys: there are " + std::to_string(keys.size()) + " keys; at most " +
                         std::to_string(max_keys) + " are permitted");
    for (const auto& [key, value] : keys.items()) {
        if (!is_live_key(scene, key))
            throw InputError("the key \"" + key.substr(0, max_text) + "\" cannot be changed in the viewer");
        state.keys.emplace_back(key, toml_of(key, value));
    }
}

void check_layer(const std::string& layer) {
    std::string names;
    for (const LayerInfo& info : all_layers()) {
        if (info.name == layer) return;
        append_to_list(names, info.name);
    }
    throw InputError("layer: \"" + layer.substr(0, max_tab) + "\" is not a layer; legal values: " + names);
}

}  // namespace

std::vector<Override> ViewState::overrides() const {
    std::vector<Override> all;
    for (const auto& [key, value] : keys) all.emplace_back(key + "=" + value, key + " = " + value);
    const Quality q = quality;
    all.emplace_back("film.size=[" + std::to_string(width) + "," + std::to_string(height) + "]", "the size");
    all.emplace_back("film.spp=" + std::to_string(q == Quality::fine ? spp : 1), "spp");
    all.emplace_back("film.layers=[" + to_toml(layer) + "]", "layer");
    return all;
}

bool is_live_key(const SceneDescription& scene, const std::string& key) {
    if (contains(common_keys, key)) return true;
    if (key == "camera.height") return scene.camera.type == CameraType::orthographic;
    const auto& formula = scene.space.formula;
    if (!formula) {
        const auto& parameters = scene.space.parameters;
        return std::any_of(parameters.begin(), parameters.end(),
                           [&](const auto& parameter) { return key == "space." + parameter.first; });
    }
    if (contains(formula_keys, key)) return true;
    for (const std::string table : {"space.let.", "space.constants."})
        if (key.starts_with(table) && is_identifier(key.substr(table.size()))) return true;
    return false;
}

bool keeps_rays(const std::string& key) { return contains(ray_keeping_keys, key); }

ViewState parse_view_state(const std::string& json, const SceneDescription& scene) {
    const Json request = Json::parse(json, nullptr, false);
    if (!request.is_object()) throw InputError("the request is not a JSON object");
    ViewState state;
    state.tab = word(request, "tab", "");
    if (!is_identifier("t" + state.tab)) throw InputError("tab: the value must consist of letters and digits");
    state.layer = word(request, "layer", state.layer);
    check_layer(state.layer);
    state.quality = quality_named(word(request, "quality", "full"));
    state.width = whole_number(request, "width", scene.film.width, min_view_edge, max_view_edge);
    state.height = whole_number(request, "height", scene.film.height, min_view_edge, max_view_edge);
    if (std::uint64_t{state.width} * state.height > max_view_pixels)
        throw InputError("width and height: the picture has more than " + std::to_string(max_view_pixels) + " pixels");
    state.spp = whole_number(request, "spp", 1, 1, max_view_spp);
    if (request.contains("keys")) read_keys(request["keys"], scene, state);
    return state;
}

}  // namespace kagero
