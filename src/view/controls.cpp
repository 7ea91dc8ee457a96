#include "view/controls.h"

#include "film/film.h"
#include "plan/names.h"

#include <cmath>

namespace kagero {
namespace {

Json parameters_json(const SceneDescription& scene, const HamiltonianInfo& info) {
    Json list = Json::array();
    if (scene.space.formula) return list;
    for (std::uint32_t i = 0; i < info.parameter_count; ++i) {
        const ParameterInfo& parameter = info.parameters[i];
        list.push_back({{"key", std::string("space.") + parameter.name},
                        {"name", parameter.name},
                        {"value", scene.space.parameters.at(i).second},
                        {"default", parameter.default_value},
                        {"least", parameter.least},
                        {"greatest", parameter.greatest},
                        {"least_open", parameter.least_open},
                        {"is_whole", parameter.unit == Unit::whole_number},
                        {"unit", name_of(parameter.unit)},
                        {"meaning", parameter.meaning}});
    }
    return list;
}

/// Returns the texts and constants of a formula; null for a built-in space.
Json formula_json(const SceneDescription& scene) {
    if (!scene.space.formula) return nullptr;
    const FormulaDescription& formula = *scene.space.formula;
    Json texts = Json::array(), constants = Json::array();
    const auto add = [&](const std::string& key, const std::string& text) {
        if (!text.empty()) texts.push_back({{"key", key}, {"text", text}});
    };
    add("space.H", formula.energy);
    for (const auto& [name, text] : formula.helpers) add("space.let." + name, text);
    add("space.domain", formula.domain);
    add("space.capture", formula.capture);
    add("space.length_scale", formula.length_scale);
    for (const auto& [name, value] : formula.constants)
        constants.push_back({{"key", "space.constants." + name}, {"name", name}, {"value", value}});
    return {{"texts", texts}, {"constants", constants}};
}

Json layers_json() {
    Json list = Json::array();
    for (const LayerInfo& layer : all_layers()) list.push_back({{"name", layer.name}, {"what", layer.what}});
    return list;
}

}  // namespace

Json controls_json(const SceneDescription& scene, const HamiltonianInfo& info) {
    const CameraDescription& camera = scene.camera;
    return {{"scene", scene.path},
            {"space",
             {{"name", scene.space.hamiltonian},
              {"what", info.what},
              {"formula", scene.space.formula ? "H = " + scene.space.formula->energy : std::string(info.formula)}}},
            {"parameters", parameters_json(scene, info)},
            {"formula", formula_json(scene)},
            {"camera",
             {{"type", name_of(camera.type)},
              {"position", camera.position},
              {"look_at", camera.look_at},
              {"up", camera.up},
              {"fov", camera.fov},
              {"height", camera.height},
              {"observer", name_of(camera.observer)},
              {"observers", observer_names()}}},
            {"film",
             {{"width", scene.film.width},
              {"height", scene.film.height},
              {"exposure", scene.film.tone.exposure},
              {"tone", tone_curve_names()[std::size_t(scene.film.tone.curve)]},
              {"tones", tone_curve_names()}}},
            {"layers", layers_json()}};
}

}  // namespace kagero
