#include "report/listing.h"

#include "error.h"
#include "film/film.h"
#include "modules/modules.h"
#include "plan/names.h"
#include "report/json.h"
#include "report/text/numbers.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

namespace kagero {

namespace {

namespace fs = std::filesystem;
// Each item of a topic has the keys `name` and `what`, a one-line description. The text listing shows the other keys
// below the line with name and description, in the order of the JSON. Keys with the value `true` are last, on one line.

Json parameter_item(const ParameterInfo& info) {
    return {{"name", info.name},         {"default", info.default_value}, {"least", info.least},
            {"greatest", info.greatest}, {"least_open", info.least_open}, {"unit", name_of(info.unit)},
            {"meaning", info.meaning}};
}

Json hamiltonian_items(const Module& module) {
    Json items = Json::array();
    for (std::uint32_t i = 0; i < module.hamiltonian_count; ++i) {
        const HamiltonianInfo& info = module.hamiltonians[i];
        Json parameters = Json::array();
        for (std::uint32_t k = 0; k < info.parameter_count; ++k)
            parameters.push_back(parameter_item(info.parameters[k]));
        items.push_back({{"name", info.name},
                         {"what", info.what},
                         {"formula", info.formula},
                         {"source", info.source},
                         {"conserved", info.conserved},
                         {"parameters", parameters},
                         {"spacetime", info.spacetime},
                         {"method", info.method},
                         {"step", info.step}});
        if (info.step_goes_with) items.back()["step_goes_with"] = info.step_goes_with;
        if (info.index_parameter) items.back()["step_goes_with_inverse_of"] = info.index_parameter;
        if (info.orbit_method) {
            items.back()["orbit_method"] = info.orbit_method;
            items.back()["orbit_step"] = info.orbit_step;
        }
    }
    return items;
}

Json integrator_items(const Module& module) {
    Json items = Json::array();
    for (std::uint32_t i = 0; i < module.integrator_count; ++i) {
        const IntegratorInfo& info = module.integrators[i];
        items.push_back({{"name", info.name},
                         {"what", info.what},
                         {"order", info.order},
                         {"symplectic", info.symplectic},
                         {"symmetric", info.symmetric},
                         {"implicit", info.implicit},
                         {"adaptive", info.adaptive},
                         {"angular", info.angular}});
    }
    return items;
}

const char* description_of(Strategy strategy) {
    switch (strategy) {
        case Strategy::scalar: return "one ray at a time without SIMD; the baseline of comparisons";
        case Strategy::per_ray:
            return "one ray at a time; the lanes hold the stages of a Gauss method or the components of the gradient";
        case Strategy::packet:
            return "one ray per lane, in lockstep, with one, two or four registers per variable; a gang is several "
                   "packets that take turns in one loop";
    }
    return "";
}

Json strategy_items(const Module& module) {
    Json items = Json::array();
    for (const Strategy strategy : {Strategy::scalar, Strategy::per_ray, Strategy::packet}) {
        Json kernels = Json::array();
        for (std::uint32_t i = 0; i < module.kernel_count; ++i) {
            const KernelInfo& info = module.kernels[i];
            if (info.strategy != strategy) continue;
            kernels.push_back(
                {{"precision", name_of(info.precision)}, {"lanes", info.lanes}, {"registers", info.registers}});
            if (info.form != Form::none) kernels.back()["form"] = name_of(info.form);
        }
        if (!kernels.empty())
            items.push_back({{"name", name_of(strategy)}, {"what", description_of(strategy)}, {"kernels", kernels}});
    }
    return items;
}

Json isa_items() {
    Json items = Json::array();
    for (const IsaInfo& info : find_isas())
        items.push_back({{"name", info.name},
                         {"what", info.supported ? "supported by this processor" : "not supported by this processor"},
                         {"supported", info.supported},
                         {"path", info.path}});
    return items;
}

/// Returns the comment on the first line of a scene file, which describes the scene; empty if there is none.
std::string first_comment(const fs::path& path) {
    std::ifstream in(path);
    std::string line;
    std::getline(in, line);
    const std::size_t text = line.find_first_not_of("# ");
    return line.starts_with('#') && text != std::string::npos ? line.substr(text) : "";
}

Json scene_items(const std::string& directory) {
    std::vector<fs::path> paths;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(directory, ignored))
        if (entry.path().extension() == ".toml") paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    Json items = Json::array();
    for (const fs::path& path : paths)
        items.push_back({{"name", path.stem().string()}, {"what", first_comment(path)}, {"path", path.string()}});
    return items;
}

Json layer_items() {
    Json items = Json::array();
    for (const LayerInfo& info : all_layers()) {
        Json channels = Json::array();
        for (const std::string& channel : info.channels) channels.push_back(info.name + "." + channel);
        items.push_back({{"name", info.name},
                         {"what", info.what},
                         {"channels", channels},
                         {"type", info.half() ? "half" : "float"}});
    }
    return items;
}

Json items_of(const std::string& topic, const std::string& isa, const std::string& scene_directory) {
    if (topic == "hamiltonians") return hamiltonian_items(load_module(isa));
    if (topic == "integrators") return integrator_items(load_module(isa));
    if (topic == "strategies") return strategy_items(load_module(isa));
    if (topic == "isas") return isa_items();
    if (topic == "scenes") return scene_items(scene_directory);
    return layer_items();
}

/// Returns one line such as "rg = 1 [length], > 0: Schwarzschild radius".
std::string parameter_text(const Json& item) {
    const double least = item["least"].get<double>(), greatest = item["greatest"].get<double>();
    std::string text = item["name"].get<std::string>() + " = " + shortest(item["default"].get<double>());
    const std::string unit = item["unit"].get<std::string>();
    if (!unit.empty()) text += " [" + unit + "]";
    if (std::isfinite(least)) text += std::string(item["least_open"].get<bool>() ? ", > " : ", >= ") + shortest(least);
    if (std::isfinite(greatest)) text += ", <= " + shortest(greatest);
    return text + ": " + item["meaning"].get<std::string>();
}

std::string kernel_text(const Json& item) {
    const auto number = [&](const char* key) { return std::to_string(item[key].get<unsigned>()); };
    return item["precision"].get<std::string>() + ", rays at a time: " + number("lanes") +
           ", registers per variable: " + number("registers") +
           (item.contains("form") ? ", " + item["form"].get<std::string>() : std::string());
}

/// Returns the text of a string, a number, or an array of these.
std::string value_text(const Json& value) {
    if (value.is_array()) {
        std::string text;
        for (const Json& entry : value) append_to_list(text, value_text(entry));
        return text;
    }
    if (value.is_string()) return value.get<std::string>();
    if (value.is_number_float()) return shortest(value.get<double>());
    return value.dump();
}

constexpr std::size_t name_width = 18;

void append_item(std::string& text, const Json& item) {
    const std::string indent(name_width + 2, ' ');
    const std::string name = item["name"].get<std::string>();
    text += "  " + name + std::string(name.size() < name_width ? name_width - name.size() : 1, ' ');
    text += item["what"].get<std::string>() + "\n";
    std::string flags;
    for (const auto& [key, value] : item.items()) {
        if (key == "name" || key == "what") continue;
        if (value.is_boolean()) {
            if (value.get<bool>()) append_to_list(flags, key);
        } else if (key == "parameters" || key == "kernels") {
            for (const Json& entry : value)
                text += indent + (key == "parameters" ? parameter_text(entry) : kernel_text(entry)) + "\n";
        } else if (!value_text(value).empty()) {
            text += indent + key + ": " + value_text(value) + "\n";
        }
    }
    if (!flags.empty()) text += indent + flags + "\n";
}

}  // namespace

const std::vector<std::string>& list_topics() {
    static const std::vector<std::string> topics{"hamiltonians", "integrators", "strategies",
                                                 "isas",         "scenes",      "layers"};
    return topics;
}

std::string listing_json(const std::vector<std::string>& topics, const std::string& isa,
                         const std::string& scene_directory) {
    Json json;
    for (const std::string& topic : topics) json[topic] = items_of(topic, isa, scene_directory);
    return text_of(json);
}

std::string listing_text(const std::vector<std::string>& topics, const std::string& isa,
                         const std::string& scene_directory) {
    std::string text;
    for (const std::string& topic : topics) {
        text += (text.empty() ? "" : "\n") + topic + "\n";
        for (const Json& item : items_of(topic, isa, scene_directory)) append_item(text, item);
    }
    return text;
}

std::string find_scene_directory() {
    std::error_code ignored;
    const fs::path program = fs::read_symlink("/proc/self/exe", ignored).parent_path();
    // An installed program lies in PREFIX/bin, with the scenes in PREFIX/share. The build writes the program to
    // build/PRESET/bin of the source tree.
    for (const char* relative : {"../share/kagero/scenes", "../../../scenes"}) {
        const fs::path directory = (program / relative).lexically_normal();
        if (fs::is_directory(directory, ignored)) return directory.string();
    }
    return "";
}

}  // namespace kagero
