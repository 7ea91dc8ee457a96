#include "scene/load/load_space.h"

#include "scene/load/load_formula.h"
#include "scene/load/load_integrator.h"
#include "scene/vector3.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Returns the legal keys of the table of a space that do not describe its Hamiltonian.
std::vector<std::string> keys_of_table(SpaceTable table, bool is_formula) {
    if (table == SpaceTable::medium) return {"hamiltonian", "center", "name", "integrator"};
    return is_formula ? std::vector<std::string>{"hamiltonian", "center", "sky_frame", "far_domain"}
                      : std::vector<std::string>{"hamiltonian", "center", "sky_frame"};
}

/// Loads the values of the parameters that a Hamiltonian declares. `other_keys` are the other legal keys of the table.
void load_parameters(const Section& section, const HamiltonianInfo& info, std::vector<std::string> other_keys,
                     SpaceDescription& space) {
    for (std::uint32_t i = 0; i < info.parameter_count; ++i) {
        const ParameterInfo& parameter = info.parameters[i];
        other_keys.insert(other_keys.begin() + 2 + i, parameter.name);
        const Value* stated = find(section, parameter.name);
        space.parameters.emplace_back(parameter.name,
                                      stated ? to_parameter(*stated, full_name(section, parameter.name), parameter)
                                             : parameter.default_value);
    }
    check_keys(section, other_keys);
}

/// Throws InputError if a medium states a key that concerns skies.
void refuse_keys_of_skies(const Section& section) {
    const auto refuse = [&](const char* key, const std::string& reason) {
        if (const Value* value = find(section, key))
            throw InputError(value->key_location, full_name(section, key) + " is not legal: " + reason +
                                                      "; remove the key, or state it in [space]");
    };
    refuse("sky_frame", "only rays that leave [space] see a sky, and they end outside all media");
    refuse("far_domain", "a medium has no second sky, because it lies inside the surfaces that bound it");
}

/// Returns the name of a medium. `others` are the media before it.
std::string load_medium_name(const Value& table, const std::vector<MediumDescription>& others) {
    const Value& name = require({&table, "medium", table.location}, "name");
    const std::string& text = to_text(name, "medium.name");
    if (text.empty()) fail(name, "medium.name", "a name that is not empty");
    if (text == "space" || text == "auto")
        fail(name, "medium.name",
             "another name: \"space\" names the table [space], and \"auto\" is a value of "
             "camera.medium");
    for (const MediumDescription& other : others)
        if (other.name == text)
            throw InputError(name.location, "two media are named " + to_toml(text) + "; the other one is in line " +
                                                std::to_string(other.location.line));
    return text;
}

}  // namespace

double to_parameter(const Value& value, const std::string& name, const ParameterInfo& parameter) {
    const double number = to_number(value, name, {parameter.least, parameter.greatest, parameter.least_open});
    if (parameter.unit == Unit::whole_number && number != std::floor(number)) fail(value, name, "a whole number");
    return number;
}

SpaceDescription load_space(const Section& section, const Catalogue& catalogue, SpaceTable table) {
    SpaceDescription space;
    const Value& name = require_type_key(section, "hamiltonian");
    const auto known = names_of(catalogue.hamiltonians, catalogue.hamiltonian_count);
    space.hamiltonian = known[to_choice(name, full_name(section, "hamiltonian"), known)];
    const HamiltonianInfo& info = *catalogue.hamiltonian_named(space.hamiltonian);
    const bool is_formula = space.hamiltonian == "formula", is_medium = table == SpaceTable::medium;
    if (is_medium) refuse_keys_of_skies(section);
    if (is_formula) space.formula = load_formula(section, keys_of_table(table, true));
    else load_parameters(section, info, keys_of_table(table, false), space);
    space.has_second_sheet = is_formula ? space.formula->far_domain_node >= 0 : info.has_second_sheet;
    read(section, "center", space.center, any_length);
    if (!is_medium) space.sky_frame = load_velocity(section, "sky_frame", space);
    return space;
}

std::vector<MediumDescription> load_media(const Value& root, const SceneDescription& scene,
                                          const Catalogue& catalogue) {
    std::vector<MediumDescription> media;
    const Value* tables = find(root, "medium");
    if (!tables) return media;
    if (tables->kind != Value::Kind::array) fail(*tables, "medium", "an array of tables, each headed [[medium]]");
    for (const Value& table : tables->items) {
        if (table.kind != Value::Kind::table) fail(table, "medium", "a table headed [[medium]]");
        MediumDescription medium;
        medium.name = load_medium_name(table, media);
        medium.location = table.location;
        const Section section{&table, "medium." + medium.name, table.location};
        medium.space = load_space(section, catalogue, SpaceTable::medium);
        // The default escape sphere of a medium encloses that of [space].
        const double escape_radius =
            std::min(scene.integrator.escape_radius + length(subtract(medium.space.center, scene.space.center)),
                     positive_length.greatest);
        medium.integrator = load_integrator(subsection(section, "integrator"), medium.space, catalogue, escape_radius);
        media.push_back(std::move(medium));
    }
    return media;
}

std::vector<std::string> names_of_media(const std::vector<MediumDescription>& media) {
    std::vector<std::string> names{"space"};
    for (const MediumDescription& medium : media) names.push_back(medium.name);
    return names;
}

}  // namespace kagero
