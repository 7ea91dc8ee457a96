#include "scene/shading.h"

#include "scene/vector3.h"

#include <algorithm>
#include <numbers>

namespace kagero {

namespace {

/// What a point of a surface looks like to the paint and the head light.
struct Appearance {
    double u = 0, v = 0;
    Double3 normal{0, 0, 1};
};

Appearance on_sphere(const ShadedObject& object, const Double3& point) {
    const Double3 normal = unit(subtract(point, object.center));
    const double latitude = std::asin(std::clamp(normal[2], -1.0, 1.0));
    return {0.5 + std::atan2(normal[1], normal[0]) / (2 * std::numbers::pi), 0.5 + latitude / std::numbers::pi, normal};
}

Appearance on_triangle(const TriangleMesh& mesh, std::uint32_t primitive, const Double3& point) {
    const std::uint32_t* index = &mesh.triangles[3 * std::size_t{primitive}];
    const Double3 a = vertex(mesh, index[0]);
    const Double3 ab = subtract(vertex(mesh, index[1]), a), ac = subtract(vertex(mesh, index[2]), a), ap = subtract(point, a);
    const Double3 area = cross(ab, ac);
    const double b = dot(cross(ap, ac), area) / dot(area, area);
    const double c = dot(cross(ab, ap), area) / dot(area, area);
    const double weights[3] = {1 - b - c, b, c};  // barycentric coordinates of the point

    Appearance appearance{0, 0, unit(area)};
    if (!mesh.uv.empty()) {
        for (std::size_t k = 0; k < 3; ++k) {
            appearance.u += weights[k] * mesh.uv[2 * std::size_t{index[k]}];
            appearance.v += weights[k] * mesh.uv[2 * std::size_t{index[k]} + 1];
        }
    }
    if (!mesh.normals.empty()) {
        Double3 normal{};
        for (std::size_t k = 0; k < 3; ++k) {
            const double* n = &mesh.normals[3 * std::size_t{index[k]}];
            normal = add(normal, scaled({n[0], n[1], n[2]}, weights[k]));
        }
        if (length(normal) > 0) appearance.normal = unit(normal);
    }
    return appearance;
}

}  // namespace

Float3 paint_color(const LoadedPaint& loaded, double u, double v, Edge vertical) {
    const Paint& paint = loaded.paint;
    switch (paint.kind) {
        case Paint::Kind::texture:
            return texture_color(*loaded.image, u, v, vertical);
        case Paint::Kind::checker:
            return checker_color(paint, u, v);
        case Paint::Kind::color:
            break;
    }
    return {static_cast<float>(paint.color[0]), static_cast<float>(paint.color[1]), static_cast<float>(paint.color[2])};
}

Float3 object_color(const ShadedObject& object, std::uint32_t primitive, const Double3& point, const Double3& toward) {
    const bool is_sphere = object.shape == Shape::sphere;
    const Appearance seen = is_sphere ? on_sphere(object, point) : on_triangle(object.mesh, primitive, point);
    const std::size_t face = object.paints.size() == 6 ? primitive / 2 : 0;
    Float3 color = paint_color(object.paints[face], seen.u, seen.v);
    if (object.shading == Shading::lambert) {
        const auto light = static_cast<float>(std::abs(dot(seen.normal, toward)));
        for (float& channel : color) channel *= light;
    }
    return color;
}

}  // namespace kagero
