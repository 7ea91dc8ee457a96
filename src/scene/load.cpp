#include "scene/load.h"
#include "scene/load_formula.h"
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

template <class Info>
std::vector<std::string> names(const Info* infos, std::uint32_t count) {
    std::vector<std::string> result;
    for (std::uint32_t i = 0; i < count; ++i) result.emplace_back(infos[i].name);
    return result;
}

const HamiltonianInfo* hamiltonian_named(const std::string& name, const Catalogue& catalogue) {
    for (std::uint32_t i = 0; i < catalogue.hamiltonian_count; ++i) {
        if (name == catalogue.hamiltonians[i].name) return &catalogue.hamiltonians[i];
    }
    return nullptr;
}

/// A scene is small; the limit keeps /dev/zero and mistaken file names from filling the memory.
std::string read_text(const std::string& path) {
    constexpr std::size_t greatest_size = std::size_t{64} << 20;
    std::error_code error;
    if (std::filesystem::is_directory(path, error)) throw InputError({path, 0, 0}, "is a directory, not a scene file");
    std::ifstream file(path, std::ios::binary);
    if (!file) throw InputError({path, 0, 0}, std::string("cannot be opened: ") + std::strerror(errno));
    std::string text;
    char buffer[1 << 16];
    while (file.read(buffer, sizeof buffer), file.gcount() > 0) {
        text.append(buffer, static_cast<std::size_t>(file.gcount()));
        if (text.size() > greatest_size) throw InputError({path, 0, 0}, "is larger than 64 MiB: not a scene file");
    }
    if (file.bad()) throw RunError("cannot read '" + path + "' to its end");
    return text;
}

/// The picture needs to know which way is up.
void check_view(const Section& section, const CameraDescription& camera) {
    const Value& look_at = need(section, "look_at");
    const Double3 forward = subtract(camera.look_at, camera.position);
    if (length(forward) == 0) fail(look_at, full_name(section, "look_at"), "a point other than camera.position");
    const Value* up = find(section, "up");
    if (length(camera.up) == 0) fail(up ? *up : look_at, full_name(section, "up"), "a vector that is not zero");
    // Closer than √ε to parallel, the cross product has lost half its digits.
    const double sine = length(cross(unit(forward), unit(camera.up)));
    if (sine > std::sqrt(std::numeric_limits<double>::epsilon())) return;
    throw InputError(up ? up->place : look_at.place,
                     "camera.up = " + written(camera.up) + (up ? "" : " (the default)") + " is parallel to the viewing direction: choose another up");
}

}  // namespace

SpaceDescription load_space(const Section& section, const Catalogue& catalogue) {
    SpaceDescription space;
    const Value& name = need_kind(section, "hamiltonian");
    const auto known = names(catalogue.hamiltonians, catalogue.hamiltonian_count);
    space.hamiltonian = known[to_choice(name, full_name(section, "hamiltonian"), known)];
    const HamiltonianInfo& info = *hamiltonian_named(space.hamiltonian, catalogue);
    space.far_sided = info.far_sided;

    if (space.hamiltonian == "formula") {
        space.formula = load_formula(section);
        read(section, "center", space.center, any_length);
        return space;
    }
    std::vector<std::string> keys{"hamiltonian", "center"};
    for (std::uint32_t i = 0; i < info.parameter_count; ++i) {
        const ParameterInfo& parameter = info.parameters[i];
        keys.emplace_back(parameter.name);
        double value = parameter.fallback;
        read(section, parameter.name, value, {parameter.least, parameter.greatest, parameter.least_open});
        if (parameter.unit == std::string("whole number") && value != std::floor(value))
            fail(need(section, parameter.name), full_name(section, parameter.name), "a whole number");
        space.parameters.emplace_back(parameter.name, value);
    }
    only_keys(section, keys);
    read(section, "center", space.center, any_length);
    return space;
}

/// How many rays a packet shall have, or 0 for "auto"; whether there are such packets the kernels know.
std::uint32_t to_lanes(const Value& lanes) {
    if (lanes.kind == Value::Kind::string) {
        if (lanes.string == "auto") return 0;
        throw InputError(lanes.place, "integrator.lanes = " + written(lanes.string) + " is neither a whole number, 1 <= value <= 1024, nor known" + suggestion(lanes.string, {"auto"}));
    }
    return to_count(lanes, "integrator.lanes", 1, 1024);
}

/// Whether rays are followed in the plane of their orbit unasked: where the space has one, and the scene says nothing that belongs to
/// another way.
bool follows_orbits(const Section& section, const IntegratorDescription& integrator, const HamiltonianInfo& info) {
    if (integrator.symmetry != "auto" || !info.orbit_method) return false;
    for (const char* key : {"method", "step", "tolerance", "solver_tolerance", "rescale"})
        if (find(section, key)) return false;
    return true;
}

/// The default method; adaptive, where one serves, if the scene states a tolerance, for which only those have a use, or does without the
/// space's rescaling and states no step: then steps of one length may be too long beside a hole.
std::string default_method(const Section& section, const HamiltonianInfo& info, const Catalogue& catalogue) {
    constexpr const char* adaptive = "dp85";
    const IntegratorInfo* const all = catalogue.integrators;
    const bool is_adaptive = std::find_if(all, all + catalogue.integrator_count, [&](const IntegratorInfo& one) {
        return one.name == std::string_view(info.method);
    })->adaptive;
    const Value* rescale = find(section, "rescale");
    const bool wants_control = find(section, "tolerance") || (rescale && rescale->string == "none" && info.rescales && !find(section, "step"));
    return wants_control && !is_adaptive && !info.creased ? adaptive : info.method;
}

/// What a formula in the parameters of a space, and escape_radius, comes to. They stand for variables: numbers may be infinite on the way.
double value_of(const char* formula, const HamiltonianInfo& info, const std::function<double(std::size_t)>& parameter, double escape_radius) {
    FormulaScope scope = formula_scope();
    std::array<double, 7> values{};
    auto add = [&, next = 0](const char* name, double value) mutable {
        values.at(static_cast<std::size_t>(next)) = value;
        define(scope, name, next++, {});
    };
    for (std::size_t i = 0; i < info.parameter_count; ++i) add(info.parameters[i].name, parameter(i));
    add("escape_radius", escape_radius);
    return evaluate(scope, parse_formula(scope, {formula, "step_goes_with", {}}), values);
}

/// The default steps, by kind.
///
/// Lengths are in proportion to that which the space names, and to the inverse of the medium's index, as what counts is the way of a step.
/// What hardly bends light is crossed in steps as long as the escape sphere is wide, no longer. Of a spacetime the default is that of the
/// rescaled H; without rescaling it goes with the first of its lengths.
std::array<double, 3> default_steps(const HamiltonianInfo& info, const SpaceDescription& space, double escape_radius) {
    const auto stated = [&](std::size_t i) { return space.parameters[i].second; };
    const auto fallback = [&](std::size_t i) { return info.parameters[i].fallback; };
    const auto over_default = [&](const char* formula) {
        const double standard = formula ? value_of(formula, info, fallback, IntegratorDescription().escape_radius) : 1;
        return formula ? value_of(formula, info, stated, escape_radius) / standard : 1;
    };
    const double way = info.step * over_default(info.step_goes_with);
    const double length = (info.step_goes_with ? std::min(way, escape_radius) : way) / over_default(info.index_parameter);
    const double angle = info.orbit_method ? info.orbit_step : 0.2;
    if (!info.spacetime || !info.rescales) return {length, length, angle};
    const ParameterInfo* const end = info.parameters + info.parameter_count;
    const ParameterInfo* const size = std::find_if(info.parameters, end, [](const ParameterInfo& one) { return one.unit == std::string_view("scene lengths"); });
    return {size == end || stated(std::size_t(size - info.parameters)) == 0 ? length : length * over_default(size->name), length, angle};
}

/// Of a method about a space, whose H is rescaled unless the scene says otherwise.
StepKind kind_of_step(const Section& section, const HamiltonianInfo& info, std::size_t method, const Catalogue& catalogue) {
    if (catalogue.integrators[method].angular) return StepKind::angle;
    const Value* rescale = find(section, "rescale");
    const bool rescaled = info.spacetime && info.rescales && !(rescale && rescale->string == "none") &&
                          !(catalogue.refusal && catalogue.refusal(std::uint32_t(&info - catalogue.hamiltonians), std::uint32_t(method), true));
    return rescaled ? StepKind::number : StepKind::length;
}

IntegratorDescription load_integrator(const Section& section, SpaceDescription& space, const Catalogue& catalogue) {
    only_keys(section, {"method", "step", "tolerance", "solver_tolerance", "max_steps", "escape_radius", "hit", "cull", "rescale",
                        "refill", "symmetry", "lanes", "max_pixel_error"});

    IntegratorDescription integrator;
    const HamiltonianInfo& info = *hamiltonian_named(space.hamiltonian, catalogue);
    integrator.method = default_method(section, info, catalogue);
    read(section, "escape_radius", integrator.escape_radius, positive_length);
    integrator.default_step = default_steps(info, space, integrator.escape_radius);
    if (const Value* symmetry = find(section, "symmetry")) {
        static const std::vector<std::string> known{"auto", "none"};
        integrator.symmetry = known[to_choice(*symmetry, "integrator.symmetry", known)];
    }
    if (follows_orbits(section, integrator, info)) integrator.method = info.orbit_method;
    const auto methods = names(catalogue.integrators, catalogue.integrator_count);
    if (const Value* method = find(section, "method")) {
        const std::size_t chosen = to_choice(*method, "integrator.method", methods);
        integrator.method = methods[chosen], integrator.method_place = method->place;
        if (integrator.symmetry == "none" && catalogue.integrators[chosen].angular)
            throw InputError(method->place, "integrator.method = \"" + methods[chosen] +
                             "\" follows rays in the plane of their orbit, which integrator.symmetry = \"none\" forbids");
    }
    const auto method = std::size_t(std::find(methods.begin(), methods.end(), integrator.method) - methods.begin());
    integrator.step = integrator.default_step[std::size_t(kind_of_step(section, info, method, catalogue))];
    read(section, "step", integrator.step, {0, 1e12, true});
    if (const Value* step = find(section, "step")) integrator.step_place = step->place;
    read(section, "tolerance", integrator.tolerance, {0, 1, true, true});
    if (const Value* tolerance = find(section, "tolerance")) integrator.tolerance_place = tolerance->place;
    read(section, "solver_tolerance", integrator.solver_tolerance, {0, 1, false, true});
    read(section, "max_pixel_error", integrator.max_pixel_error, {0, 1e6, true});
    if (const Value* steps = find(section, "max_steps")) {
        integrator.max_steps = to_count(*steps, "integrator.max_steps", 1, std::numeric_limits<std::uint32_t>::max());
    }
    if (const Value* hit = find(section, "hit")) {
        integrator.hit = to_choice(*hit, "integrator.hit", {"chord", "hermite"}) == 0 ? HitModel::chord : HitModel::hermite;
    }
    if (const Value* cull = find(section, "cull")) integrator.cull = to_choice(*cull, "integrator.cull", {"auto", "none"}) == 0;
    if (const Value* lanes = find(section, "lanes")) integrator.lanes = to_lanes(*lanes), integrator.lanes_place = lanes->place;
    if (const Value* refill = find(section, "refill")) {
        static const std::vector<std::string> known{"auto", "on", "off"};
        integrator.refill = known[to_choice(*refill, "integrator.refill", known)];
    }
    if (const Value* rescale = find(section, "rescale")) {
        integrator.rescale = to_text(*rescale, "integrator.rescale");
        load_rescaling(*rescale, space, integrator);
    }
    return integrator;
}

CameraDescription load_camera(const Section& section) {
    CameraDescription camera;
    std::vector<std::string> keys{"type", "position", "look_at", "up", "fov", "observer"};
    if (const Value* type = find(section, "type")) {
        const std::vector<std::string> types{"perspective", "equirectangular", "orthographic"};
        camera.type = types[to_choice(*type, "camera.type", types)];
    }
    if (camera.type == "orthographic") keys.emplace_back("height");
    only_keys(section, keys);
    if (const Value* observer = find(section, "observer")) {
        camera.observer = observer_names()[to_choice(*observer, "camera.observer", observer_names())], camera.observer_place = observer->place;
    }
    const Value& position = need(section, "position");
    camera.position = to_double3(position, "camera.position", any_length);
    camera.position_place = position.place;
    camera.look_at = to_double3(need(section, "look_at"), "camera.look_at", any_length);
    read(section, "up", camera.up, any_length);
    read(section, "fov", camera.fov, {0, 180, true, true});
    if (const Value* fov = find(section, "fov")) camera.fov_place = fov->place;
    read(section, "height", camera.height, positive_length);
    check_view(section, camera);
    return camera;
}

FilmDescription load_film(const Section& section, const std::vector<std::string>& layers) {
    only_keys(section, {"size", "spp", "seed", "layers"});
    FilmDescription film;
    const Value& size = need(section, "size");
    if (size.kind != Value::Kind::array || size.items.size() != 2) fail(size, "film.size", "[width, height]");
    film.width = to_count(size.items[0], "film.size[0]", 1, 65536);
    film.height = to_count(size.items[1], "film.size[1]", 1, 65536);
    if (const Value* spp = find(section, "spp")) film.spp = to_count(*spp, "film.spp", 1, 65536);
    if (const Value* seed = find(section, "seed")) {
        film.seed = to_count(*seed, "film.seed", 0, std::numeric_limits<std::uint32_t>::max());
    }
    if (const Value* chosen = find(section, "layers")) {
        if (chosen->kind != Value::Kind::array || chosen->items.empty()) fail(*chosen, "film.layers", "an array of layer names");
        film.layers.clear();
        for (const Value& layer : chosen->items) {
            const std::string& name = layers[to_choice(layer, "film.layers", layers)];
            for (const std::string& other : film.layers) {
                if (other == name) fail(layer, "film.layers", "every layer once");
            }
            film.layers.push_back(name);
        }
    }
    return film;
}

SkyDescription load_sky(const Section& section, const std::string& directory) {
    std::vector<std::string> keys{"color", "texture", "checker", "pole"};
    if (section.name == "sky") keys.emplace_back("far");
    only_keys(section, keys);
    SkyDescription sky;
    sky.paint = load_paint(section, sky.paint, CheckerKey::flag, directory);
    read(section, "pole", sky.pole, any_length);
    if (length(sky.pole) == 0) fail(need(section, "pole"), full_name(section, "pole"), "a vector that is not zero");
    return sky;
}

SkyDescription load_far_sky(const Section& sky, const SpaceDescription& space, const std::string& directory) {
    const Value* far = find(sky, "far");
    if (!far) return {};
    if (far->kind != Value::Kind::table) fail(*far, "sky.far", "a table: [sky.far]");
    if (!space.far_sided)
        throw InputError(far->place, "sky.far: " + written(space.hamiltonian) + " has one universe and one sky: leave the table out");
    return load_sky({far, "sky.far", far->place}, directory);
}

const std::vector<std::string>& observer_names() {
    static const std::vector<std::string> names{"static", "zamo", "falling", "coordinate"};
    return names;
}

SceneDescription load_scene(const std::string& path, const std::vector<Override>& overrides, const Catalogue& catalogue) {
    return load_scene_text(read_text(path), path, overrides, catalogue);
}

SceneDescription load_scene_text(const std::string& text, const std::string& path, const std::vector<Override>& overrides,
                                 const Catalogue& catalogue) {
    SceneDescription scene;
    scene.path = path;
    scene.text = text;
    Value root = parse_toml(scene.text, path);
    root.place = {path, 1, 1};
    for (const Override& one : overrides) {
        scene.overrides.push_back(one.text);
        apply_override(root, one.text, one.said.empty() ? "-D " + one.text : one.said);
    }

    only_keys({&root, "", root.place}, {"space", "integrator", "camera", "film", "sky", "object"});
    const std::string directory = std::filesystem::path(path).parent_path().string();
    scene.space = load_space(section(root, "space"), catalogue);
    scene.integrator = load_integrator(section(root, "integrator"), scene.space, catalogue);
    scene.camera = load_camera(section(root, "camera"));
    scene.film = load_film(section(root, "film"), catalogue.layers);
    const Section sky = section(root, "sky");
    scene.sky = load_sky(sky, directory);
    scene.far_sky = load_far_sky(sky, scene.space, directory);
    scene.objects = load_objects(root, directory);
    return scene;
}

}  // namespace kagero
