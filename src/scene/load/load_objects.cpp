#include "scene/load/load_objects.h"

#include "scene/load/load_formula.h"
#include "scene/load/load_material.h"
#include "scene/load/load_space.h"
#include "scene/vector3.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace kagero {

namespace {

constexpr Range color_range{0, 1e6};
constexpr Range checker_range{0, 1e6, true};
/// Temperatures in kelvin. Colder bodies emit no visible light; all hotter bodies have nearly the same colour.
constexpr Range temperature_range{500, 1e9};

/// Returns the legal keys of an object with the given shape.
std::vector<std::string> keys_of(Shape shape) {
    std::vector<std::string> keys{"name", "shape", "color", "texture", "checker", "shading"};
    std::vector<std::string> shape_keys;
    switch (shape) {
        case Shape::rectangle: shape_keys = {"origin", "edge_u", "edge_v"}; break;
        case Shape::box:
        case Shape::room: shape_keys = {"min", "max", "faces"}; break;
        case Shape::sphere: shape_keys = {"center", "radius"}; break;
        case Shape::mesh: shape_keys = {"file", "translate", "rotate", "scale", "materials"}; break;
        case Shape::disk: shape_keys = {"center", "normal", "inner", "outer", "temperature", "velocity"}; break;
    }
    keys.insert(keys.end(), shape_keys.begin(), shape_keys.end());
    keys.insert(keys.end(), material_keys().begin(), material_keys().end());
    return keys;
}

Double3 require_vector(const Section& section, const std::string& key) {
    return to_double3(require(section, key), full_name(section, key), any_length);
}

void load_rectangle(const Section& section, ObjectDescription& object) {
    object.origin = require_vector(section, "origin");
    object.edge_u = require_vector(section, "edge_u");
    object.edge_v = require_vector(section, "edge_v");
    for (const char* key : {"edge_u", "edge_v"}) {
        const Double3& edge = key[5] == 'u' ? object.edge_u : object.edge_v;
        if (length(edge) == 0) fail(require(section, key), full_name(section, key), "a vector that is not zero");
    }
    const double sine = length(cross(unit(object.edge_u), unit(object.edge_v)));
    if (sine <= std::sqrt(std::numeric_limits<double>::epsilon())) {
        fail(require(section, "edge_v"), full_name(section, "edge_v"), "a vector that is not parallel to edge_u");
    }
}

void load_faces(const Section& section, const std::string& directory, ObjectDescription& object) {
    object.faces.fill(object.paint);
    const Value* table = find(section, "faces");
    if (!table) return;
    const std::string name = full_name(section, "faces");
    if (table->kind != Value::Kind::table) fail(*table, name, "a table with keys among px, nx, py, ny, pz, nz");
    check_keys({table, name, table->location}, face_names());
    for (std::size_t i = 0; i < 6; ++i) {
        const Value* face = find(*table, face_names()[i]);
        if (!face) continue;
        const std::string face_name = name + '.' + face_names()[i];
        Paint& paint = object.faces[i];
        if (face->kind == Value::Kind::array) {
            paint = {};
            paint.color = to_double3(*face, face_name, color_range);
            paint.location = face->location;
        } else if (face->kind == Value::Kind::table) {
            const Section entry{face, face_name, face->location};
            check_keys(entry, {"color", "texture", "checker"});
            paint = load_paint(entry, paint, CheckerKey::counts, directory);
        } else {
            fail(*face, face_name, "a colour [r, g, b], or a table with color, texture or checker");
        }
    }
}

void load_box(const Section& section, const std::string& directory, ObjectDescription& object) {
    object.min = require_vector(section, "min");
    object.max = require_vector(section, "max");
    for (std::size_t i = 0; i < 3; ++i) {
        if (object.min[i] < object.max[i]) continue;
        const Value& max = require(section, "max");
        fail(max, full_name(section, "max"),
             "greater than min in every coordinate, but min[" + std::to_string(i) + "] = " + to_toml(object.min[i]));
    }
    load_faces(section, directory, object);
}

void load_sphere(const Section& section, ObjectDescription& object) {
    object.center = require_vector(section, "center");
    object.radius = to_number(require(section, "radius"), full_name(section, "radius"), positive_length);
}

void load_disk(const Section& section, SpaceDescription& space, ObjectDescription& object) {
    object.center = require_vector(section, "center");
    read(section, "normal", object.normal, any_length);
    if (length(object.normal) == 0)
        fail(require(section, "normal"), full_name(section, "normal"), "a vector that is not zero");
    const Value* normal = find(section, "normal");
    object.center_location = require(section, "center").location;
    object.normal_location = normal ? normal->location : object.location;
    object.inner = to_number(require(section, "inner"), full_name(section, "inner"), positive_length);
    const Value& outer = require(section, "outer");
    object.outer = to_number(outer, full_name(section, "outer"), positive_length);
    if (object.outer <= object.inner)
        fail(outer, full_name(section, "outer"), "greater than inner = " + to_toml(object.inner));
    object.velocity = load_velocity(section, "velocity", space);
    const Value* temperature = find(section, "temperature");
    if (!temperature) return;
    for (const char* key : {"color", "texture", "checker"}) {
        if (!find(section, key)) continue;
        throw InputError(temperature->key_location,
                         full_name(section, "temperature") + " and " + key + " exclude each other; remove one of them");
    }
    object.temperature = to_number(*temperature, full_name(section, "temperature"), temperature_range);
}

void load_mesh_keys(const Section& section, const std::string& directory, ObjectDescription& object) {
    const Value& file = require(section, "file");
    const std::string name = full_name(section, "file");
    std::string extension = std::filesystem::path(to_text(file, name)).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    const std::vector<std::string> supported{".obj", ".ply", ".gltf", ".glb"};
    if (std::find(supported.begin(), supported.end(), extension) == supported.end())
        fail(file, name, "a .obj, .ply, .gltf or .glb file");
    if (object.has_file_materials && extension == ".ply")
        fail(require(section, "materials"), full_name(section, "materials"),
             "\"scene\", because PLY files contain no materials; use an .obj, .gltf or .glb file for \"file\"");
    object.file = to_file(file, name, directory);
    object.file_location = file.location;
    read(section, "translate", object.translate, any_length);
    read(section, "rotate", object.rotate, any_angle);
    read(section, "scale", object.scale, positive_length);
}

ObjectDescription load_object(const Value& table, const std::string& name, const std::string& directory,
                              SpaceDescription& space, const std::vector<std::string>& media) {
    const Section section{&table, "object." + name, table.location};
    ObjectDescription object;
    object.name = name;
    object.location = table.location;
    const Value& shape = require_type_key(section, "shape");
    object.shape = static_cast<Shape>(to_choice(shape, full_name(section, "shape"), shape_names()));
    check_keys(section, keys_of(object.shape));
    object.paint = load_paint(section, object.paint, CheckerKey::counts, directory);
    if (const Value* shading = find(section, "shading")) {
        const std::size_t choice = to_choice(*shading, full_name(section, "shading"), {"emission", "lambert"});
        object.shading = static_cast<Shading>(choice);
    }
    load_material(section, media, object);
    object.faces.fill(object.paint);
    switch (object.shape) {
        case Shape::rectangle: load_rectangle(section, object); break;
        case Shape::box:
        case Shape::room: load_box(section, directory, object); break;
        case Shape::sphere: load_sphere(section, object); break;
        case Shape::mesh: load_mesh_keys(section, directory, object); break;
        case Shape::disk: load_disk(section, space, object); break;
    }
    check_albedo(section, object);
    return object;
}

}  // namespace

Paint load_paint(const Section& section, const Paint& default_paint, CheckerKey checker_key,
                 const std::string& directory) {
    const Value* color = find(section, "color");
    const Value* texture = find(section, "texture");
    const Value* checker = find(section, "checker");
    if (checker && checker_key != CheckerKey::counts) {
        if (checker->kind != Value::Kind::boolean) fail(*checker, full_name(section, "checker"), "true or false");
        if (!checker->boolean) checker = nullptr;
    }
    if (!color && !texture && !checker) return default_paint;
    if (texture && (color || checker)) {
        const std::string other = color ? "color" : "checker";
        throw InputError(texture->key_location,
                         full_name(section, "texture") + " and " + other + " exclude each other; remove one of them");
    }
    Paint paint;
    paint.location = (texture ? texture : checker ? checker : color)->location;
    if (color) paint.color = to_double3(*color, full_name(section, "color"), color_range);
    if (texture) {
        paint.kind = Paint::Kind::texture;
        paint.texture = to_file(*texture, full_name(section, "texture"), directory);
    }
    if (!checker) return paint;
    paint.kind = Paint::Kind::checker;
    paint.checker = checker_key == CheckerKey::counts
                        ? to_double2(*checker, full_name(section, "checker"), checker_range)
                        : std::array<double, 2>{24, 12};  // squares of 15° by 15° on a sky
    return paint;
}

std::vector<ObjectDescription> load_objects(const Value& root, const std::string& directory, SpaceDescription& space,
                                            const std::vector<MediumDescription>& media) {
    const std::vector<std::string> medium_names = names_of_media(media);
    std::vector<ObjectDescription> objects;
    const Value* tables = find(root, "object");
    if (!tables) return objects;
    if (tables->kind != Value::Kind::array) fail(*tables, "object", "an array of tables, each headed [[object]]");
    for (const Value& table : tables->items) {
        if (table.kind != Value::Kind::table) fail(table, "object", "a table headed [[object]]");
        std::string name = "object-" + std::to_string(objects.size() + 1);
        const Value* given = find(table, "name");
        if (given) name = to_text(*given, "object." + name + ".name");
        if (name.empty())
            fail(*given, "object.name", "a name that is not empty; without the key, the object gets a default name");
        for (const ObjectDescription& other : objects) {
            if (other.name != name) continue;
            const FileLocation& location = given ? given->location : table.location;
            throw InputError(location, "two objects are named " + to_toml(name) + "; the other one is in line " +
                                           std::to_string(other.location.line));
        }
        objects.push_back(load_object(table, name, directory, space, medium_names));
    }
    return objects;
}

}  // namespace kagero
