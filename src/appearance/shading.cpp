#include "appearance/shading.h"

#include "appearance/blackbody.h"
#include "scene/vector3.h"

#include <algorithm>

namespace kagero {

namespace {

/// Texture coordinates of a point on a surface, and the sides of the patch around the point in these coordinates.
struct PaintedPatch {
    double u = 0, v = 0;
    UvPatch sides;
};

PaintedPatch painted_patch(const ChartPoint& point, const Patch& patch) {
    return {point.u, point.v, to_uv(point, patch)};
}

PaintedPatch painted_patch(const ShadedObject& object, std::uint32_t primitive, const Double3& point,
                           const Patch& patch) {
    if (object.geometry->shape == Shape::sphere)
        return painted_patch(sphere_uv(subtract(point, object.geometry->center)), patch);
    if (object.geometry->shape == Shape::disk)
        return painted_patch(disk_uv(object.normal, object.inner, object.outer,
                                     subtract(point, object.geometry->center)),
                             patch);
    if (object.charts.empty()) return {};
    const TriangleChart& chart = object.charts[primitive];
    const auto [u, v] = triangle_uv(chart, point);
    return {u, v, to_uv(chart, patch)};
}

Float3 paint_color(const ShadedObject& object, const LoadedPaint& loaded, std::uint32_t primitive, const Double3& point,
                   const Patch& patch) {
    if (!has_pattern(loaded)) return plain_color(loaded.paint);
    if (loaded.image && object.geometry->shape == Shape::sphere)
        return sphere_texture_color(*loaded.image, *loaded.coarser, subtract(point, object.geometry->center),
                                    patch.right, patch.below);
    const PaintedPatch painted = painted_patch(object, primitive, point, patch);
    if (!loaded.image)
        return checker_color(loaded.paint, painted.u, painted.v, painted.sides, edges_of(object, loaded));
    Float3 color = surface_texture_color(*loaded.image, *loaded.coarser, painted.u, painted.v, painted.sides,
                                         edges_of(object, loaded));
    for (std::size_t k = 0; k < 3; ++k) color[k] *= static_cast<float>(loaded.paint.factor[k]);
    return color;
}

/// Returns the colour of a disk that radiates as a black body.
[[gnu::noinline]] Float3 black_body_color(const ShadedObject& disk, const Double3& point, double redshift) {
    const double kelvin = observed_temperature(disk, point, redshift);
    if (!(kelvin > 0)) return {0, 0, 0};
    const std::array<double, 3> rgb = blackbody_color(kelvin);
    Float3 color;
    for (std::size_t k = 0; k < 3; ++k) color[k] = static_cast<float>(disk.inverse_luminance * rgb[k]);
    return color;
}

Double3 normal_on(const ShadedObject& object, std::uint32_t primitive, const Double3& point) {
    if (object.geometry->shape == Shape::sphere) return subtract(point, object.geometry->center);
    if (object.geometry->shape == Shape::disk) return object.normal;
    return interpolated_normal(object.geometry->mesh, primitive, point);
}

void multiply(Float3& color, double factor) {
    for (float& channel : color) channel *= static_cast<float>(factor);
}

}  // namespace

Double3 interpolated_normal(const TriangleMesh& mesh, std::uint32_t primitive, const Double3& point) {
    const std::uint32_t* index = &mesh.triangles[3 * std::size_t{primitive}];
    const Double3 a = vertex(mesh, index[0]);
    const Double3 ab = subtract(vertex(mesh, index[1]), a), ac = subtract(vertex(mesh, index[2]), a),
                  ap = subtract(point, a);
    const Double3 geometric_normal = cross(ab, ac);
    if (mesh.normals.empty()) return geometric_normal;
    const double square = dot(geometric_normal, geometric_normal);
    const double b = dot(cross(ap, ac), geometric_normal) / square;
    const double c = dot(cross(ab, ap), geometric_normal) / square;
    const double weights[3] = {1 - b - c, b, c};  // barycentric coordinates of the point
    Double3 normal{};
    for (std::size_t k = 0; k < 3; ++k) {
        const double* n = &mesh.normals[3 * std::size_t{index[k]}];
        normal = add(normal, scaled({n[0], n[1], n[2]}, weights[k]));
    }
    return dot(normal, normal) > 0 ? normal : geometric_normal;
}

Edges edges_of(const ShadedObject& object, const LoadedPaint& loaded) {
    const Shape shape = object.geometry->shape;
    if (shape == Shape::mesh) return {loaded.paint.along_u, loaded.paint.along_v};
    return shape == Shape::sphere || shape == Shape::disk ? repeat_along_u : clamp_both;
}

const LoadedPaint& paint_of(const ShadedObject& object, std::uint32_t primitive) {
    return object.paints[object.paints.size() == 6 ? primitive / 2 : 0];
}

ChartPoint surface_coordinates(const ShadedObject& object, std::uint32_t primitive, const Double3& point) {
    if (object.geometry->shape == Shape::sphere) return sphere_uv(subtract(point, object.geometry->center));
    if (object.geometry->shape == Shape::disk)
        return disk_uv(object.normal, object.inner, object.outer, subtract(point, object.geometry->center));
    if (object.charts.empty()) return {};
    const TriangleChart& chart = object.charts[primitive];
    const auto [u, v] = triangle_uv(chart, point);
    ChartPoint result{u, v, {}, {}};
    for (std::size_t k = 0; k < 3; ++k) {
        result.u_gradient[k] = chart.gradient[k][0];
        result.v_gradient[k] = chart.gradient[k][1];
    }
    return result;
}

double lambert_factor(const ShadedObject& object, std::uint32_t primitive, const Double3& point,
                      const Double3& ray_direction) {
    if (object.shading != Shading::lambert) return 1;
    return std::abs(dot(unit(normal_on(object, primitive, point)), ray_direction));
}

bool has_pattern(const LoadedPaint& paint) {
    return paint.paint.kind != Paint::Kind::color;
}

double observed_temperature(const ShadedObject& disk, const Double3& point, double redshift) {
    const double radius = std::max(length(subtract(point, disk.geometry->center)), disk.inner),
                 root = std::sqrt(radius / disk.inner);
    return disk.temperature / (root * std::sqrt(root)) * redshift;
}

Float3 plain_color(const Paint& paint) {
    return {static_cast<float>(paint.color[0]), static_cast<float>(paint.color[1]), static_cast<float>(paint.color[2])};
}

Float3 object_color(const ShadedObject& object, std::uint32_t primitive, const Double3& point,
                    const Double3& ray_direction, double redshift, const Patch& patch, const Float3* black_body) {
    Float3 color;
    if (object.temperature > 0) {
        color = black_body ? *black_body : black_body_color(object, point, redshift);
    } else {
        color = paint_color(object, paint_of(object, primitive), primitive, point, patch);
        if (object.geometry->shape == Shape::disk) multiply(color, redshift * redshift * (redshift * redshift));
    }
    if (object.shading == Shading::lambert)
        multiply(color, lambert_factor(object, primitive, point, ray_direction));
    return color;
}

Float3 emission_color(const ShadedObject& object, std::uint32_t primitive, const Double3& point) {
    return paint_color(object, *object.emission, primitive, point, {});
}

Float3 sky_color(const LoadedPaint& paint, const SkyAxes& axes, const Double3& direction, const SkyFilter& filter) {
    if (!has_pattern(paint)) return plain_color(paint.paint);
    if (paint.image) return sky_texture_color(*paint.image, *paint.coarser, direction, axes, filter);
    const ChartPoint point = sky_uv(direction, axes);
    const UvPatch sides = to_uv(point, {filter.footprint.major, filter.footprint.minor});
    return checker_color(paint.paint, point.u, point.v, sides, repeat_along_u);
}

}  // namespace kagero
