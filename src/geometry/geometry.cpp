#include "geometry/geometry.h"

#include "geometry/clearance.h"
#include "geometry/embree.h"
#include "geometry/mesh.h"
#include "scene/value.h"
#include "scene/vector3.h"

#include <algorithm>
#include <limits>

namespace kagero {

struct SceneGeometry::Content {
    std::vector<ObjectGeometry> objects;
    std::vector<Surface> surfaces;
    std::unique_ptr<EmbreeScene> embree;
    Geometry geometry{};
    Clearance clearance;
    std::vector<std::string> remarks;
    double diagonal = 0;
};

namespace {

ObjectGeometry load(const ObjectDescription& object, const Double3& space_center, std::vector<std::string>& remarks) {
    ObjectGeometry loaded;
    loaded.shape = object.shape;
    loaded.center = subtract(object.center, space_center);
    switch (object.shape) {
        case Shape::rectangle: loaded.mesh = rectangle_mesh(object, space_center); break;
        case Shape::box:
        case Shape::room: loaded.mesh = box_mesh(object, space_center); break;
        case Shape::sphere: break;
        case Shape::mesh: loaded.mesh = load_mesh(object, space_center, remarks); break;
        case Shape::disk: loaded.mesh = disk_mesh(object, space_center); break;
    }
    loaded.planes = planes_of(loaded.mesh);
    return loaded;
}

/// Points into `loaded`, which must stay where it is.
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

std::vector<Ring> rings_of(const std::vector<ObjectDescription>& descriptions,
                           const std::vector<ObjectGeometry>& objects) {
    std::vector<Ring> rings;
    for (std::size_t i = 0; i < objects.size(); ++i)
        if (objects[i].shape == Shape::disk)
            rings.push_back(
                {static_cast<std::uint32_t>(i), objects[i].center, descriptions[i].inner, descriptions[i].outer});
    return rings;
}

void include(const ObjectGeometry& object, const Surface& surface, Bounds& bounds) {
    for (const std::uint32_t index : object.mesh.triangles) bounds.include(vertex(object.mesh, index));
    if (surface.kind == Surface::Kind::sphere) bounds.include(object.center, surface.radius);
}

Bounds bounds_of(const std::vector<ObjectGeometry>& objects, const std::vector<Surface>& surfaces) {
    Bounds bounds;
    for (std::size_t i = 0; i < objects.size(); ++i) include(objects[i], surfaces[i], bounds);
    return bounds;
}

/// Brings the objects into [−1, 1] by a power of two, and the middle near 0 by multiples of an eighth of the size, so
/// that round numbers stay round.
void choose_coordinates(const SceneDescription& scene, const Bounds& bounds, Geometry& geometry) {
    const Double3 size = subtract(bounds.upper, bounds.lower);
    const double half = 0.5 * std::max({size[0], size[1], size[2]});
    const double camera = length(subtract(scene.camera.position, scene.space.center));
    const double farthest =
        std::max({scene.integrator.escape_radius, camera, length(bounds.lower), length(bounds.upper)});
    if (half <= 1e-12 * farthest) {
        throw InputError(scene.objects.front().place, "the objects together are " + written(half / farthest) +
                                                          " times as large as the greatest of integrator.escape_radius "
                                                          "and of the distances of camera and objects from "
                                                          "space.center: expected more than 1e-12");
    }
    geometry.scale = std::scalbn(1.0, -(std::ilogb(half) + 1));
    for (std::size_t i = 0; i < 3; ++i) {
        const double middle = 0.5 * (bounds.lower[i] + bounds.upper[i]);
        geometry.shift[i] = std::round(middle * geometry.scale * 4) / (geometry.scale * 4);
    }
}

/// Embree's numbers are of single precision and of all objects together: of what is small and lies far off they are too
/// few.
void remark_on_small(const ObjectDescription& description, const ObjectGeometry& object, const Surface& surface,
                     const Geometry& geometry, std::vector<std::string>& remarks) {
    constexpr double visible = 1e-3;
    Bounds own;
    include(object, surface, own);
    double size = 0, farthest = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        size = std::max(size, own.upper[i] - own.lower[i]);
        farthest = std::max(
            {farthest, std::abs(own.lower[i] - geometry.shift[i]), std::abs(own.upper[i] - geometry.shift[i])});
    }
    const double rounded = 0.5 * double(std::numeric_limits<float>::epsilon()) * farthest / size;
    if (rounded > visible)
        remarks.push_back("object " + description.name +
                          ": it is so small beside all objects together that it is met up to " + written(rounded) +
                          " of its size off, as Embree has single precision");
}

}  // namespace

SceneGeometry::SceneGeometry(const SceneDescription& scene, std::uint32_t clearance_cells)
    : content_(std::make_unique<Content>()) {
    Content& content = *content_;
    if (scene.objects.empty()) return;

    content.objects.reserve(scene.objects.size());
    std::vector<std::size_t> vertex_counts, triangle_counts;
    for (const ObjectDescription& object : scene.objects) {
        content.objects.push_back(load(object, scene.space.center, content.remarks));
        content.surfaces.push_back(surface_of(object, content.objects.back()));
        vertex_counts.push_back(content.objects.back().mesh.vertices.size() / 3);
        triangle_counts.push_back(content.objects.back().mesh.triangles.size() / 3);
    }
    const Bounds bounds = bounds_of(content.objects, content.surfaces);
    content.diagonal = length(subtract(bounds.upper, bounds.lower));

    Geometry& geometry = content.geometry;
    choose_coordinates(scene, bounds, geometry);
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
        remark_on_small(scene.objects[i], content.objects[i], content.surfaces[i], geometry, content.remarks);
    content.embree = std::make_unique<EmbreeScene>(content.surfaces, vertex_counts, triangle_counts,
                                                   rings_of(scene.objects, content.objects), geometry.shift,
                                                   Double3{geometry.scale, geometry.scale, geometry.scale});
    geometry.embree_scene = content.embree->scene();
    geometry.surfaces = content.surfaces.data();
    geometry.surface_count = static_cast<std::uint32_t>(content.surfaces.size());
    if (!clearance_cells || !scene.integrator.cull) return;
    const Double3 stretch = clearance_stretch(bounds);
    std::unique_ptr<EmbreeScene> stretched;
    if (stretch != Double3{1, 1, 1})
        stretched = std::make_unique<EmbreeScene>(content.surfaces, vertex_counts, triangle_counts, std::vector<Ring>{},
                                                  geometry.shift, scaled(stretch, geometry.scale));
    content.clearance =
        build_clearance(geometry, (stretched ? *stretched : *content.embree).scene(), stretch, bounds, clearance_cells);
    geometry.clearance = &content.clearance.grid;
}

SceneGeometry::~SceneGeometry() = default;

const Geometry* SceneGeometry::kernel_view() const {
    return content_->embree ? &content_->geometry : nullptr;
}

const std::vector<ObjectGeometry>& SceneGeometry::objects() const {
    return content_->objects;
}

bool SceneGeometry::on_same_face(std::uint32_t surface, std::uint32_t primitive, const Double3& point,
                                 std::uint32_t other_primitive, const Double3& other) const {
    const ObjectGeometry& object = content_->objects[surface];
    if (primitive == other_primitive) return true;
    const bool has_faces = object.shape == Shape::box || object.shape == Shape::room;
    if (object.shape != Shape::mesh) return !has_faces || primitive / 2 == other_primitive / 2;
    constexpr double steepest = 0.5;  // sine of the angle between the way and the triangles
    const Double3 way = subtract(other, point);
    const auto leads_along = [&](std::uint32_t triangle) {
        const double* plane = &object.planes[4 * std::size_t{triangle}];
        return std::abs(dot({plane[0], plane[1], plane[2]}, way)) <= steepest * length(way);
    };
    return leads_along(primitive) && leads_along(other_primitive);
}

const std::vector<std::string>& SceneGeometry::remarks() const {
    return content_->remarks;
}

double SceneGeometry::nearest(double limit) const {
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

double SceneGeometry::diagonal() const {
    return content_->diagonal;
}

}  // namespace kagero
