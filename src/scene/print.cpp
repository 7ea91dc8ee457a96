// All keys are written, including defaults, so that the text contains everything on which the picture depends.
#include "scene/print.h"

#include "scene/value.h"

#include <algorithm>
#include <sstream>

namespace kagero {

namespace {

template <class T>
std::string text_of(const T& value) {
    return to_toml(value);
}
std::string text_of(std::uint32_t number) {
    return std::to_string(number);
}

std::string text_of(const VelocityDescription& velocity) {
    std::string list;
    for (const std::string& component : velocity.components) append_to_list(list, component);
    return '[' + list + ']';
}

/// Function object that writes lines "key = value".
struct KeyLine {
    std::ostringstream& out;
    template <class T>
    void operator()(const std::string& key, const T& value) const {
        out << key << " = " << text_of(value) << '\n';
    }
};

/// Returns the keys color, texture and checker of a paint as texts "key = value".
std::vector<std::string> paint_pairs(const Paint& paint, bool checker_is_flag) {
    switch (paint.kind) {
        case Paint::Kind::color:
            return {"color = " + text_of(paint.color)};
        case Paint::Kind::texture:
            return {"texture = " + to_toml(paint.texture)};
        case Paint::Kind::checker:
            break;
    }
    return {"color = " + text_of(paint.color), "checker = " + (checker_is_flag ? "true" : text_of(paint.checker))};
}

bool same_paint(const Paint& a, const Paint& b) {
    return a.kind == b.kind && a.color == b.color && a.texture == b.texture && a.checker == b.checker;
}

void print_faces(std::ostringstream& out, const ObjectDescription& object) {
    out << "\n[object.faces]\n";
    for (std::size_t i = 0; i < 6; ++i) {
        std::string text;
        for (const std::string& pair : paint_pairs(object.faces[i], false)) append_to_list(text, pair);
        out << face_names()[i] << " = { " << text << " }\n";
    }
}

void print_shape(const KeyLine& line, const ObjectDescription& object) {
    switch (object.shape) {
        case Shape::rectangle:
            line("origin", object.origin);
            line("edge_u", object.edge_u);
            line("edge_v", object.edge_v);
            break;
        case Shape::box:
        case Shape::room:
            line("min", object.min);
            line("max", object.max);
            break;
        case Shape::sphere:
            line("center", object.center);
            line("radius", object.radius);
            break;
        case Shape::mesh:
            line("file", object.file);
            line("translate", object.translate);
            line("rotate", object.rotate);
            line("scale", object.scale);
            break;
        case Shape::disk:
            line("center", object.center);
            line("normal", object.normal);
            line("inner", object.inner);
            line("outer", object.outer);
            if (object.velocity) line("velocity", *object.velocity);
            break;
    }
}

/// Writes the keys of a mirror or boundary.
void print_material(const KeyLine& line, const SceneDescription& scene, const ObjectDescription& object) {
    line("material", material_names()[static_cast<std::size_t>(object.material)]);
    if (object.material == Material::boundary) {
        line("interior", name_of_medium(scene, object.interior));
        line("exterior", name_of_medium(scene, object.exterior));
        line("fresnel", fresnel_names()[static_cast<std::size_t>(object.fresnel)]);
    }
    line("tint", object.tint);
}

/// Writes an object. `has_materials` is true if a surface of the scene sends light on.
void print_object(std::ostringstream& out, const SceneDescription& scene, const ObjectDescription& object,
                  bool has_materials) {
    const KeyLine line{out};
    out << "\n[[object]]\n";
    line("name", object.name);
    line("shape", shape_names()[static_cast<std::size_t>(object.shape)]);
    print_shape(line, object);
    if (object.shape == Shape::mesh && object.has_file_materials) {
        line("materials", std::string("file"));
        if (!object.states_material) return;
        line("material", std::string("surface"));
        line("shading", std::string(object.shading == Shading::lambert ? "lambert" : "emission"));
        return;
    }
    if (object.shape == Shape::mesh) line("materials", std::string("scene"));
    const bool is_diffuse = object.material == Material::diffuse;
    if (object.material != Material::surface && !is_diffuse) {
        print_material(line, scene, object);
        return;
    }
    if (has_materials) line("material", material_names()[static_cast<std::size_t>(object.material)]);
    if (object.temperature > 0) line("temperature", object.temperature);
    else for (const std::string& pair : paint_pairs(object.paint, false)) out << pair << '\n';
    if (is_diffuse) line("emission_strength", object.emission_strength);
    else line("shading", std::string(object.shading == Shading::lambert ? "lambert" : "emission"));
    bool faces_differ = false;
    for (const Paint& face : object.faces) faces_differ = faces_differ || !same_paint(face, object.paint);
    if (faces_differ) print_faces(out, object);
}

/// Writes the keys of a formula and its tables. `table` is the name of the table of the space.
void print_formula(std::ostringstream& out, const SpaceDescription& space, const std::string& table) {
    const KeyLine line{out};
    const FormulaDescription& formula = *space.formula;
    line("H", formula.energy);
    line("H0", formula.level);
    if (!formula.parts.empty())
        out << "parts = [" << to_toml(formula.parts[0]) << ", " << to_toml(formula.parts[1]) << "]\n";
    if (!formula.domain.empty()) line("domain", formula.domain);
    if (!formula.far_domain.empty()) line("far_domain", formula.far_domain);
    if (!formula.capture.empty()) line("capture", formula.capture);
    if (!formula.length_scale.empty()) line("length_scale", formula.length_scale);
    line("center", space.center);
    if (space.sky_frame) line("sky_frame", *space.sky_frame);
    out << "\n[" << table << ".constants]\n";
    for (const auto& [name, value] : formula.constants) line(name, value);
    if (formula.helpers.empty()) return;
    out << "\n[" << table << ".let]\n";
    for (const auto& [name, text] : formula.helpers) line(name, text);
}

/// Writes the keys of a space. `table` is the name of its table.
void print_space(std::ostringstream& out, const SpaceDescription& space, const std::string& table) {
    const KeyLine line{out};
    line("hamiltonian", space.hamiltonian);
    for (const auto& [name, value] : space.parameters) line(name, value);
    if (space.formula) {
        print_formula(out, space, table);
        return;
    }
    line("center", space.center);
    if (space.sky_frame) line("sky_frame", *space.sky_frame);
}

/// Returns true if the default method `name` can be a default only without solver_tolerance and rescale: the methods
/// for the orbit plane and for the separated motion.
bool has_angular_steps(const std::string& name) { return name.starts_with("orbit-") || name.starts_with("mino-"); }

/// Writes the table of an integrator.
void print_integrator(std::ostringstream& out, const IntegratorDescription& integrator, const std::string& table) {
    const KeyLine line{out};
    out << "\n[" << table << "]\n";
    // A default method is written as a TOML comment if it may still change: a trial may choose another method unless
    // the scene states a step or tolerance; with a stated rescaling, the method may not support the rescaling. A
    // default step or tolerance is a comment too, because a trial chooses it. If the default has angular steps,
    // the keys solver_tolerance and rescale are comments: if they were stated, the default would be another method.
    const bool states_step = integrator.step_location || integrator.tolerance_location;
    const bool method_may_change = !integrator.method_location &&
                                   (integrator.max_pixel_error > 0 || integrator.rescale != "auto" || !states_step);
    const char* comment_out = method_may_change && has_angular_steps(integrator.method) ? "# " : "";
    if (method_may_change) out << "# ";
    line("method", integrator.method);
    out << (integrator.step_location ? comment_out : "# ");
    line("step", integrator.step);
    out << (integrator.tolerance_location ? comment_out : "# ") << "tolerance = " << to_toml(integrator.tolerance)
        << "  # for adaptive methods only\n";
    out << comment_out << "solver_tolerance = " << to_toml(integrator.solver_tolerance)
        << (integrator.solver_tolerance == 0 ? "  # to rounding\n" : "\n");
    line("max_steps", integrator.max_steps);
    line("escape_radius", integrator.escape_radius);
    line("hit", std::string(integrator.hit == HitModel::chord ? "chord" : "hermite"));
    line("cull", std::string(integrator.cull ? "auto" : "none"));
    line("refill", refill_names()[static_cast<std::size_t>(integrator.refill)]);
    line("symmetry", std::string(integrator.use_symmetry ? "auto" : "none"));
    if (integrator.max_pixel_error > 0) line("max_pixel_error", integrator.max_pixel_error);
    if (integrator.lanes) line("lanes", integrator.lanes);
    else line("lanes", std::string("auto"));
    out << comment_out;
    line("rescale", integrator.rescale);
}

/// Writes the table of a medium.
void print_medium(std::ostringstream& out, const MediumDescription& medium) {
    out << "\n[[medium]]\n";
    KeyLine{out}("name", medium.name);
    print_space(out, medium.space, "medium");
    print_integrator(out, medium.integrator, "medium.integrator");
}

/// Writes the table [camera]. The medium is written if it is stated, or if the scene has boundaries.
void print_camera(std::ostringstream& out, const CameraDescription& camera, bool has_boundaries) {
    const KeyLine line{out};
    out << "\n[camera]\n";
    line("type", name_of(camera.type));
    line("position", camera.position);
    line("look_at", camera.look_at);
    line("up", camera.up);
    if (camera.type == CameraType::perspective) line("fov", camera.fov);
    if (camera.type == CameraType::orthographic) line("height", camera.height);
    if (camera.velocity) line("velocity", *camera.velocity);
    else line("observer", name_of(camera.observer));
    if (has_boundaries || camera.medium_location) line("medium", camera.medium);
    line("shutter", camera.shutter);
    if (camera.type != CameraType::perspective) return;
    line("aperture_radius", camera.aperture_radius);
    if (!camera.states_focus_distance) out << "# ";  // the distance of look_at, which an animation can change
    line("focus_distance", camera.focus_distance);
}

void print_sky(std::ostringstream& out, const std::string& name, const SkyDescription& sky) {
    out << "\n[" << name << "]\n";
    for (const std::string& pair : paint_pairs(sky.paint, true)) out << pair << '\n';
    KeyLine{out}("pole", sky.pole);
}

/// Writes the tables [animation] and [animation.set].
void print_animation(std::ostringstream& out, const AnimationDescription& animation) {
    const KeyLine line{out};
    out << "\n[animation]\n";
    line("frames", animation.frames);
    line("fps", animation.fps);
    if (animation.keys.empty()) return;
    out << "\n[animation.set]\n";
    for (const AnimatedKey& key : animation.keys) {
        std::string numbers;
        for (const AnimatedNumber& number : key.numbers) append_to_list(numbers, number.text);
        out << to_toml(key.key) << " = " << (key.is_array ? '[' + numbers + ']' : numbers) << '\n';
    }
}

void print_skies(std::ostringstream& out, const SceneDescription& scene) {
    print_sky(out, "sky", scene.sky);
    if (scene.space.has_second_sheet) print_sky(out, "sky.far", scene.far_sky);
}

/// Returns true if a surface of the scene sends light on.
bool has_materials_beside_surface(const SceneDescription& scene) {
    return has_material(scene, Material::boundary) || has_material(scene, Material::mirror) ||
           has_material(scene, Material::diffuse);
}

void print_objects(std::ostringstream& out, const SceneDescription& scene) {
    const bool has_materials = has_materials_beside_surface(scene);
    for (const ObjectDescription& object : scene.objects) print_object(out, scene, object, has_materials);
}

}  // namespace

std::string print_surfaces(const SceneDescription& scene) {
    std::ostringstream out;
    print_objects(out, scene);
    return out.str();
}

std::string print_skies(const SceneDescription& scene) {
    std::ostringstream out;
    print_skies(out, scene);
    return out.str();
}

std::string print_scene(const SceneDescription& scene) {
    std::ostringstream out;
    const KeyLine line{out};
    const bool has_boundaries = has_material(scene, Material::boundary),
               has_materials = has_materials_beside_surface(scene);
    out << "[space]\n";
    print_space(out, scene.space, "space");
    print_integrator(out, scene.integrator, "integrator");
    for (const MediumDescription& medium : scene.media) print_medium(out, medium);
    print_camera(out, scene.camera, has_boundaries);

    out << "\n[film]\nsize = [" << scene.film.width << ", " << scene.film.height << "]\n";
    line("spp", scene.film.spp);
    line("seed", scene.film.seed);
    line("exposure", scene.film.tone.exposure);
    line("tone", tone_curve_names()[static_cast<std::size_t>(scene.film.tone.curve)]);
    line("sampling", sampling_names()[static_cast<std::size_t>(scene.film.sampling)]);
    line("max_interpolation_error", scene.film.max_interpolation_error);
    std::string layers;
    for (const std::string& layer : scene.film.layers) append_to_list(layers, to_toml(layer));
    out << "layers = [" << layers << "]\n";
    if (has_materials || scene.film.max_bounces != FilmDescription().max_bounces)
        line("max_bounces", scene.film.max_bounces);
    print_skies(out, scene);
    print_objects(out, scene);
    if (scene.animation) print_animation(out, *scene.animation);
    return out.str();
}

}  // namespace kagero
