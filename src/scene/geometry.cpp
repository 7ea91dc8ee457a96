#include "scene/geometry.h"

#include "scene/blackbody.h"
#include "scene/clearance.h"
#include "scene/embree.h"
#include "scene/mesh.h"
#include "scene/pyramid.h"
#include "scene/shading.h"

#include <algorithm>
#include <map>

namespace kagero {

struct LoadedSky {
    LoadedPaint paint;
    Double3 pole{};
    std::vector<Image> coarser;  ///< copies of the image, if it is one
};

struct SceneGeometry::Content {
    Double3 space_center{};
    LoadedSky sky, far_sky;
    std::vector<ShadedObject> objects;  ///< surface i is object i
    std::vector<Surface> surfaces;
    std::unique_ptr<EmbreeScene> embree;
    Geometry geometry{};
    Clearance clearance;
    std::vector<std::string> remarks;
    double diagonal = 0;
};

namespace {

/// Images by path, so that one used twice is read once.
using Images = std::map<std::string, std::shared_ptr<const Image>>;

LoadedPaint load(const Paint& paint, Images& images) {
    LoadedPaint loaded{paint, nullptr};
    if (paint.kind != Paint::Kind::texture) return loaded;
    auto& image = images[paint.texture];
    if (!image) image = std::make_shared<const Image>(read_image(paint.texture, paint.place));
    loaded.image = image;
    return loaded;
}

LoadedSky load(const SkyDescription& description, Images& images) {
    LoadedSky sky{load(description.paint, images), description.pole, {}};
    if (sky.paint.image) sky.coarser = coarser_images(*sky.paint.image);
    return sky;
}

ShadedObject load(const ObjectDescription& object, const Double3& space_center, Images& images,
                  std::vector<std::string>& remarks) {
    ShadedObject shaded;
    shaded.shape = object.shape;
    shaded.shading = object.shading;
    shaded.center = subtract(object.center, space_center);
    switch (object.shape) {
        case Shape::rectangle:
            shaded.mesh = rectangle_mesh(object, space_center);
            break;
        case Shape::box:
        case Shape::room:
            shaded.mesh = box_mesh(object, space_center);
            for (const Paint& face : object.faces) shaded.paints.push_back(load(face, images));
            return shaded;
        case Shape::sphere:
            break;
        case Shape::mesh:
            shaded.mesh = load_mesh(object, space_center, remarks);
            break;
        case Shape::disk:
            shaded.mesh = disk_mesh(object, space_center);
            shaded.normal = object.normal;
            shaded.inner = object.inner, shaded.outer = object.outer, shaded.temperature = object.temperature;
            if (object.temperature > 0) shaded.brightness = 1 / blackbody_luminance(object.temperature);
            break;
    }
    shaded.paints.push_back(load(object.paint, images));
    return shaded;
}

/// Points into `shaded`, which must stay where it is.
Surface surface_of(const ObjectDescription& object, const ShadedObject& shaded) {
    Surface surface{};
    surface.kind = object.shape == Shape::sphere ? Surface::Kind::sphere : Surface::Kind::triangles;
    surface.vertices = shaded.mesh.vertices.data();
    surface.triangles = shaded.mesh.triangles.data();
    std::copy(shaded.center.begin(), shaded.center.end(), surface.center);
    surface.radius = object.radius;
    return surface;
}

std::vector<Ring> rings_of(const std::vector<ShadedObject>& objects) {
    std::vector<Ring> rings;
    for (std::size_t i = 0; i < objects.size(); ++i) {
        const ShadedObject& object = objects[i];
        if (object.shape != Shape::disk) continue;
        rings.push_back({static_cast<std::uint32_t>(i), object.center, object.inner, object.outer});
    }
    return rings;
}

Bounds bounds_of(const std::vector<ShadedObject>& objects, const std::vector<Surface>& surfaces) {
    Bounds bounds;
    for (std::size_t i = 0; i < objects.size(); ++i) {
        const TriangleMesh& mesh = objects[i].mesh;
        for (const std::uint32_t index : mesh.triangles) bounds.include(vertex(mesh, index));
        if (surfaces[i].kind == Surface::Kind::sphere) bounds.include(objects[i].center, surfaces[i].radius);
    }
    return bounds;
}

/// Brings the objects into [−1, 1] by a power of two, and the middle near 0 by multiples of an eighth of the size, so that round
/// numbers stay round.
void choose_coordinates(const SceneDescription& scene, const Bounds& bounds, Geometry& geometry) {
    const Double3 size = subtract(bounds.upper, bounds.lower);
    const double half = 0.5 * std::max({size[0], size[1], size[2]});
    const double camera = length(subtract(scene.camera.position, scene.space.center));
    const double farthest = std::max({scene.integrator.escape_radius, camera, length(bounds.lower), length(bounds.upper)});
    if (half <= 1e-12 * farthest) {
        throw InputError(scene.objects.front().place,
                         "the objects together are smaller than 1e-12 of the distance to the camera or "
                         "of integrator.escape_radius: enlarge them");
    }
    geometry.scale = std::scalbn(1.0, -(std::ilogb(half) + 1));
    for (std::size_t i = 0; i < 3; ++i) {
        const double middle = 0.5 * (bounds.lower[i] + bounds.upper[i]);
        geometry.shift[i] = std::round(middle * geometry.scale * 4) / (geometry.scale * 4);
    }
}

}  // namespace

SceneGeometry::SceneGeometry(const SceneDescription& scene, bool clearance) : content_(std::make_unique<Content>()) {
    Content& content = *content_;
    Images images;
    content.space_center = scene.space.center;
    content.sky = load(scene.sky, images);
    content.far_sky = load(scene.far_sky, images);
    if (scene.objects.empty()) return;

    content.objects.reserve(scene.objects.size());
    std::vector<std::size_t> vertex_counts, triangle_counts;
    for (const ObjectDescription& object : scene.objects) {
        content.objects.push_back(load(object, scene.space.center, images, content.remarks));
        content.surfaces.push_back(surface_of(object, content.objects.back()));
        vertex_counts.push_back(content.objects.back().mesh.vertices.size() / 3);
        triangle_counts.push_back(content.objects.back().mesh.triangles.size() / 3);
    }
    const Bounds bounds = bounds_of(content.objects, content.surfaces);
    content.diagonal = length(subtract(bounds.upper, bounds.lower));

    Geometry& geometry = content.geometry;
    choose_coordinates(scene, bounds, geometry);
    content.embree = std::make_unique<EmbreeScene>(content.surfaces, vertex_counts, triangle_counts, rings_of(content.objects),
                                                   geometry.shift, geometry.scale);
    geometry.embree_scene = content.embree->scene();
    geometry.surfaces = content.surfaces.data();
    geometry.surface_count = static_cast<std::uint32_t>(content.surfaces.size());
    if (!clearance || !scene.integrator.cull) return;
    content.clearance = build_clearance(geometry, bounds);
    geometry.clearance = &content.clearance.grid;
}

SceneGeometry::~SceneGeometry() = default;
SceneGeometry::SceneGeometry(SceneGeometry&&) noexcept = default;

const Geometry* SceneGeometry::kernel_view() const {
    return content_->embree ? &content_->geometry : nullptr;
}

std::uint32_t SceneGeometry::object_of(std::uint32_t surface) const {
    return surface;
}

Float3 SceneGeometry::surface_color(std::uint32_t surface, std::uint32_t primitive, const Double3& point,
                                    const Double3& toward, double redshift) const {
    return object_color(content_->objects[surface], primitive, subtract(point, content_->space_center), toward, redshift);
}

Float3 SceneGeometry::sky_color(const Double3& direction, bool far, const Footprint& footprint) const {
    const LoadedSky& sky = far ? content_->far_sky : content_->sky;
    if (sky.paint.paint.kind == Paint::Kind::color) return paint_color(sky.paint, 0, 0);
    if (sky.paint.image) return sky_texture_color(*sky.paint.image, sky.coarser, direction, sky.pole, footprint);
    const auto [u, v] = sky_coordinates(direction, sky.pole);
    return paint_color(sky.paint, u, v, Edge::clamp);
}

bool SceneGeometry::has_sky_image() const {
    return content_->sky.paint.image || content_->far_sky.paint.image;
}

const std::vector<std::string>& SceneGeometry::remarks() const {
    return content_->remarks;
}

double SceneGeometry::diagonal() const {
    return content_->diagonal;
}

}  // namespace kagero
