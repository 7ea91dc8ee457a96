#include "geometry/geometry.h"

#include "geometry/clearance/clearance.h"
#include "geometry/embree.h"
#include "geometry/mesh.h"
#include "scene/value.h"
#include "scene/vector3.h"

#include <algorithm>
#include <limits>
#include <numbers>

namespace kagero {

struct SceneGeometry::Content {
    std::vector<ObjectGeometry> objects;
    std::vector<ObjectGeometry> reflected;  ///< Copies of objects for the kernels, reflected; they do not move.
    std::vector<Surface> surfaces;
    std::unique_ptr<EmbreeScene> embree;
    Geometry geometry{};
    Clearance clearance;
    std::vector<std::string> remarks;
    double diagonal = 0;
};

namespace {

/// Returns everything that determines a mesh from a file and its remarks, as a text; "" for other shapes.
std::string file_inputs_of(const ObjectDescription& object, const Double3& space_center) {
    if (object.shape != Shape::mesh) return "";
    return object.name + ' ' + object.file + ' ' + std::to_string(static_cast<int>(object.paint.kind)) + ' ' +
           to_toml(object.scale) + to_toml(object.rotate) + to_toml(object.translate) + to_toml(space_center);
}

/// Loads an object. `earlier`, if not null, is the same object in another frame.
ObjectGeometry load(const ObjectDescription& object, const Double3& space_center, const ObjectGeometry* earlier) {
    ObjectGeometry loaded;
    loaded.file_inputs = file_inputs_of(object, space_center);
    if (earlier && !loaded.file_inputs.empty() && earlier->file_inputs == loaded.file_inputs) return *earlier;
    loaded.shape = object.shape;
    loaded.center = subtract(object.center, space_center);
    switch (object.shape) {
        case Shape::rectangle: loaded.mesh = rectangle_mesh(object, space_center); break;
        case Shape::box:
        case Shape::room: loaded.mesh = box_mesh(object, space_center); break;
        case Shape::sphere: break;
        case Shape::mesh: loaded.mesh = load_mesh(object, space_center, loaded.file_remarks); break;
        case Shape::disk: loaded.mesh = disk_mesh(object, space_center); break;
    }
    loaded.planes = planes_of(loaded.mesh);
    return loaded;
}

/// Returns a surface that points into `loaded`. `loaded` must not be moved, and it must outlive the surface.
Surface surface_of(const ObjectDescription& object, const ObjectGeometry& loaded) {
    Surface surface{};
    surface.kind = object.shape == Shape::sphere ? Surface::Kind::sphere : Surface::Kind::triangles;
    surface.vertices = loaded.mesh.vertices.data();
    surface.triangles = loaded.mesh.triangles.data();
    surface.planes = loaded.planes.data();
    std::copy(loaded.center.begin(), loaded.center.end(), surface.center);
    surface.radius = object.radius;
    return surface;
}

/// Returns the range of an object; a sphere has the given radius. On a sphere, the extrema lie in the plane through its
/// centre and the z axis.
SpheroidRange range_of_object(const ObjectGeometry& object, double radius, const Spheroid& spheroid) {
    const double stretch = spheroid.equator / spheroid.pole;
    SpheroidRange range{std::numeric_limits<double>::infinity(), 0};
    const auto extend = [&range](double distance) {
        range.least = std::min(range.least, distance);
        range.greatest = std::max(range.greatest, distance);
    };
    if (object.shape == Shape::sphere) {
        constexpr int samples = 4096;
        const double rho = std::hypot(object.center[0], object.center[1]);
        for (int i = 0; i < samples; ++i) {
            const double angle = 2 * std::numbers::pi * i / samples;
            extend(std::hypot(rho + radius * std::cos(angle), stretch * (object.center[2] + radius * std::sin(angle))));
        }
    }
    const auto corner = [&](std::uint32_t index) {
        const Double3 v = vertex(object.mesh, index);
        return Double3{v[0], v[1], stretch * v[2]};
    };
    const auto& index = object.mesh.triangles;
    for (std::size_t i = 0; i + 2 < index.size(); i += 3) {
        const Double3 a = corner(index[i]), b = corner(index[i + 1]), c = corner(index[i + 2]);
        extend(length(closest_point({0, 0, 0}, a, b, c)));
        for (const Double3& v : {a, b, c}) extend(length(v));
    }
    return {range.least / spheroid.equator, range.greatest / spheroid.equator};
}

/// Returns the object reflected, y → −y.
ObjectGeometry reflected_object(const ObjectGeometry& object) {
    ObjectGeometry reflected = object;
    reflected.center[1] = -reflected.center[1];
    for (std::size_t i = 1; i < reflected.mesh.vertices.size(); i += 3)
        reflected.mesh.vertices[i] = -reflected.mesh.vertices[i];
    reflected.planes = planes_of(reflected.mesh);
    return reflected;
}

std::vector<Ring> rings_of(const std::vector<ObjectDescription>& descriptions,
                           const std::vector<ObjectGeometry>& objects) {
    std::vector<Ring> rings;
    for (std::size_t i = 0; i < objects.size(); ++i)
        if (objects[i].shape == Shape::disk)
            rings.push_back(
                {static_cast<std::uint32_t>(i), objects[i].center, descriptions[i].inner, descriptions[i].outer});
    return rings;
}

/// Extends the bounds by an object as the kernels see it: reflected, if its surface is.
void extend_bounds(Bounds& bounds, const ObjectGeometry& object, const Surface& surface) {
    for (const std::uint32_t index : object.mesh.triangles) {
        const double* v = surface.vertices + 3 * std::size_t{index};
        bounds.extend({v[0], v[1], v[2]});
    }
    if (surface.kind == Surface::Kind::sphere)
        bounds.extend({surface.center[0], surface.center[1], surface.center[2]}, surface.radius);
}

Bounds bounds_of(const std::vector<ObjectGeometry>& objects, const std::vector<Surface>& surfaces) {
    Bounds bounds;
    for (std::size_t i = 0; i < objects.size(); ++i) extend_bounds(bounds, objects[i], surfaces[i]);
    return bounds;
}

/// Chooses the scale and shift of Embree's coordinates. The scale is the power of two for which half the longest edge
/// of the bounding box of all objects is in [½, 1). The shift is the multiple of ¼ of Embree's unit that is nearest to
/// the middle of this box. With these values, coordinates with few binary digits are exact in single precision.
void choose_coordinates(const SceneDescription& scene, const Bounds& bounds, Geometry& geometry) {
    const Double3 size = subtract(bounds.upper, bounds.lower);
    const double half_edge = 0.5 * std::max({size[0], size[1], size[2]});
    const double camera = length(subtract(scene.camera.position, scene.space.center));
    const double farthest =
        std::max({scene.integrator.escape_radius, camera, length(bounds.lower), length(bounds.upper)});
    if (half_edge <= 1e-12 * farthest) {
        throw InputError(scene.objects.front().location,
                         "the objects are too small: half the size of all objects together is " +
                             to_toml(half_edge / farthest) +
                             " times the greatest of integrator.escape_radius and the distances of the camera and the "
                             "objects from space.center. The ratio must be greater than 1e-12. Enlarge the objects, or "
                             "reduce the escape radius and the distances");
    }
    geometry.scale = std::scalbn(1.0, -(std::ilogb(half_edge) + 1));
    for (std::size_t i = 0; i < 3; ++i) {
        const double middle = 0.5 * (bounds.lower[i] + bounds.upper[i]);
        geometry.shift[i] = std::round(middle * geometry.scale * 4) / (geometry.scale * 4);
    }
}

/// Adds a remark if rounding to single precision visibly displaces an object. All objects share the scale and shift of
/// Embree's coordinates, so the coordinates of a small object far from the middle differ in few bits.
void remark_on_displacement(const ObjectDescription& description, const ObjectGeometry& object, const Surface& surface,
                            const Geometry& geometry, std::vector<std::string>& remarks) {
    constexpr double visible_displacement = 1e-3;  // relative to the size of the object
    Bounds bounds;
    extend_bounds(bounds, object, surface);
    double size = 0, farthest = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        size = std::max(size, bounds.upper[i] - bounds.lower[i]);
        farthest = std::max(
            {farthest, std::abs(bounds.lower[i] - geometry.shift[i]), std::abs(bounds.upper[i] - geometry.shift[i])});
    }
    const double displacement = 0.5 * double(std::numeric_limits<float>::epsilon()) * farthest / size;
    if (displacement > visible_displacement)
        remarks.push_back("object " + description.name + ": Embree's single precision displaces it by up to " +
                          to_toml(displacement) +
                          " of its size, because it is small and far from the middle of all objects. Enlarge it, or "
                          "move it closer to the other objects");
}

}  // namespace

SceneGeometry::SceneGeometry(const SceneDescription& scene, std::uint32_t clearance_cells,
                             const std::optional<Spheroid>& reflected, const SceneGeometry* earlier)
    : content_(std::make_unique<Content>()) {
    Content& content = *content_;
    if (scene.objects.empty()) return;

    content.objects.reserve(scene.objects.size());
    content.reflected.reserve(scene.objects.size());
    std::vector<std::size_t> triangle_counts;
    for (const ObjectDescription& object : scene.objects) {
        const std::size_t index = content.objects.size();
        const bool has_earlier = earlier && index < earlier->objects().size();
        content.objects.push_back(load(object, scene.space.center, has_earlier ? &earlier->objects()[index] : nullptr));
        const ObjectGeometry* for_kernels = &content.objects.back();
        content.remarks.insert(content.remarks.end(), for_kernels->file_remarks.begin(),
                               for_kernels->file_remarks.end());
        if (reflected && range_of_object(*for_kernels, object.radius, *reflected).greatest < 1)
            for_kernels = &content.reflected.emplace_back(reflected_object(*for_kernels));
        content.surfaces.push_back(surface_of(object, *for_kernels));
        triangle_counts.push_back(content.objects.back().mesh.triangles.size() / 3);
    }
    const Bounds bounds = bounds_of(content.objects, content.surfaces);
    content.diagonal = length(subtract(bounds.upper, bounds.lower));

    Geometry& geometry = content.geometry;
    choose_coordinates(scene, bounds, geometry);
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
        remark_on_displacement(scene.objects[i], content.objects[i], content.surfaces[i], geometry, content.remarks);
    content.embree =
        std::make_unique<EmbreeScene>(content.surfaces, triangle_counts, rings_of(scene.objects, content.objects),
                                      geometry.shift, Double3{geometry.scale, geometry.scale, geometry.scale});
    geometry.embree_scene = content.embree->scene();
    geometry.surfaces = content.surfaces.data();
    geometry.surface_count = static_cast<std::uint32_t>(content.surfaces.size());
    geometry.has_spheres = std::any_of(content.surfaces.begin(), content.surfaces.end(),
                                       [](const Surface& surface) { return surface.kind == Surface::Kind::sphere; });
    if (!clearance_cells || !scene.integrator.cull) return;
    const Double3 stretch = clearance_stretch(bounds);
    std::unique_ptr<EmbreeScene> stretched;  // for point queries, which ignore spheres and rings
    if (stretch != Double3{1, 1, 1})
        stretched = std::make_unique<EmbreeScene>(content.surfaces, triangle_counts, std::vector<Ring>{},
                                                  geometry.shift, scaled(stretch, geometry.scale));
    content.clearance =
        build_clearance(geometry, (stretched ? *stretched : *content.embree).scene(), stretch, bounds, clearance_cells);
    geometry.clearance = &content.clearance.grid;
}

SceneGeometry::~SceneGeometry() = default;

const Geometry* SceneGeometry::kernel_view() const { return content_->embree ? &content_->geometry : nullptr; }

const std::vector<ObjectGeometry>& SceneGeometry::objects() const { return content_->objects; }

bool SceneGeometry::on_same_face(std::uint32_t surface, std::uint32_t primitive, const Double3& point,
                                 std::uint32_t other_primitive, const Double3& other_point) const {
    const ObjectGeometry& object = content_->objects[surface];
    if (primitive == other_primitive) return true;
    const bool has_faces = object.shape == Shape::box || object.shape == Shape::room;
    if (object.shape != Shape::mesh) return !has_faces || primitive / 2 == other_primitive / 2;
    constexpr double max_sine = 0.5;  // sine of the angle between the segment and the plane of each triangle
    const Double3 segment = subtract(other_point, point);
    const auto is_nearly_parallel = [&](std::uint32_t triangle) {
        const double* plane = &object.planes[4 * std::size_t{triangle}];
        return std::abs(dot({plane[0], plane[1], plane[2]}, segment)) <= max_sine * length(segment);
    };
    return is_nearly_parallel(primitive) && is_nearly_parallel(other_primitive);
}

Face SceneGeometry::face_of(std::uint32_t surface, std::uint32_t primitive) const {
    const Shape shape = content_->objects[surface].shape;
    if (shape == Shape::mesh) return {surface, primitive, primitive};
    if (shape == Shape::box || shape == Shape::room) return {surface, primitive & ~1u, primitive | 1u};
    return {surface, 0, std::numeric_limits<std::uint32_t>::max()};
}

const std::vector<std::string>& SceneGeometry::remarks() const { return content_->remarks; }

double SceneGeometry::distance_from_center(double limit) const {
    return content_->embree ? distance_to_surfaces(content_->geometry, {0, 0, 0}, limit) : limit;
}

bool SceneGeometry::comes_within(std::uint32_t surface, double radius) const {
    const ObjectGeometry& object = content_->objects[surface];
    if (object.shape == Shape::sphere)
        return std::abs(length(object.center) - content_->surfaces[surface].radius) <= radius;
    const auto& index = object.mesh.triangles;
    for (std::size_t i = 0; i + 2 < index.size(); i += 3) {
        const Double3 nearest = closest_point({0, 0, 0}, vertex(object.mesh, index[i]),
                                              vertex(object.mesh, index[i + 1]), vertex(object.mesh, index[i + 2]));
        if (length(nearest) <= radius) return true;
    }
    return false;
}

SpheroidRange SceneGeometry::range_of(std::uint32_t surface, const Spheroid& spheroid) const {
    return range_of_object(content_->objects[surface], content_->surfaces[surface].radius, spheroid);
}

double SceneGeometry::diagonal() const { return content_->diagonal; }

}  // namespace kagero
