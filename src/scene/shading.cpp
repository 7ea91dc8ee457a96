#include "scene/shading.h"

#include "scene/blackbody.h"
#include "scene/vector3.h"

#include <algorithm>
#include <numbers>

namespace kagero {

namespace {

/// What a point of a surface looks like to the paint and the head light.
struct Appearance {
    double u = 0, v = 0;
    Double3 normal{0, 0, 1};  ///< of any length
};

Appearance on_sphere(const ShadedObject& object, const Double3& point) {
    const Double3 normal = unit(subtract(point, object.center));
    const double latitude = std::asin(std::clamp(normal[2], -1.0, 1.0));
    return {0.5 + std::atan2(normal[1], normal[0]) / (2 * std::numbers::pi), 0.5 + latitude / std::numbers::pi, normal};
}

/// u once around from +x made orthogonal to the normal, v from the inner to the outer edge.
Appearance on_disk(const ShadedObject& disk, const Double3& point) {
    const auto [zero, quarter] = meridians(disk.normal);
    const Double3 from_center = subtract(point, disk.center);
    const double angle = std::atan2(dot(from_center, quarter), dot(from_center, zero)) / (2 * std::numbers::pi);
    const double across = (length(from_center) - disk.inner) / (disk.outer - disk.inner);
    return {angle < 0 ? angle + 1 : angle, std::clamp(across, 0.0, 1.0), disk.normal};
}

/// T ∝ r^(−3/4), far from the edge of a disk that radiates away what it gains by falling (Shakura and Sunyaev 1973).
Float3 glow(const ShadedObject& disk, const Double3& point, double redshift) {
    const double radius = std::max(length(subtract(point, disk.center)), disk.inner);
    const double kelvin = disk.temperature * std::pow(radius / disk.inner, -0.75) * redshift;
    if (!(kelvin > 0)) return {0, 0, 0};
    const std::array<double, 3> rgb = blackbody_color(kelvin);
    Float3 color;
    for (std::size_t k = 0; k < 3; ++k) color[k] = static_cast<float>(disk.brightness * rgb[k]);
    return color;
}

Float3 disk_color(const ShadedObject& disk, const Appearance& seen, const Double3& point, double redshift) {
    if (disk.temperature > 0) return glow(disk, point, redshift);
    const double g2 = redshift * redshift;
    Float3 color = paint_color(disk.paints[0], seen.u, seen.v, Edge::clamp);
    for (float& channel : color) channel *= static_cast<float>(g2 * g2);
    return color;
}

Appearance on_triangle(const TriangleMesh& mesh, std::uint32_t primitive, const Double3& point) {
    const std::uint32_t* index = &mesh.triangles[3 * std::size_t{primitive}];
    const Double3 a = vertex(mesh, index[0]);
    const Double3 ab = subtract(vertex(mesh, index[1]), a), ac = subtract(vertex(mesh, index[2]), a), ap = subtract(point, a);
    const Double3 area = cross(ab, ac);
    const double b = dot(cross(ap, ac), area) / dot(area, area);
    const double c = dot(cross(ab, ap), area) / dot(area, area);
    const double weights[3] = {1 - b - c, b, c};  // barycentric coordinates of the point

    Appearance appearance{0, 0, area};
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
        if (dot(normal, normal) > 0) appearance.normal = normal;
    }
    return appearance;
}

Appearance appearance_of(const ShadedObject& object, std::uint32_t primitive, const Double3& point) {
    if (object.shape == Shape::sphere) return on_sphere(object, point);
    if (object.shape == Shape::disk) return on_disk(object, point);
    return on_triangle(object.mesh, primitive, point);
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

Float3 object_color(const ShadedObject& object, std::uint32_t primitive, const Double3& point, const Double3& toward,
                    double redshift) {
    const Appearance seen = appearance_of(object, primitive, point);
    const std::size_t face = object.paints.size() == 6 ? primitive / 2 : 0;
    const bool is_disk = object.shape == Shape::disk;
    Float3 color = is_disk ? disk_color(object, seen, point, redshift) : paint_color(object.paints[face], seen.u, seen.v);
    if (object.shading == Shading::lambert) {
        const auto light = static_cast<float>(std::abs(dot(unit(seen.normal), toward)));
        for (float& channel : color) channel *= light;
    }
    return color;
}

}  // namespace kagero
