#include "media/regions.h"

#include "error.h"
#include "media/agreement.h"
#include "scene/value.h"

#include <algorithm>

namespace kagero {
namespace {

/// Returns the unit normal of a surface at its point nearest to q; none if this point is farther away than `width`. The
/// normal of a sphere points outward.
std::optional<Double3> normal_near(const ExactSurface& surface, const Double3& q, double width) {
    if (!surface.mesh) {
        const Double3 offset = subtract(q, surface.center);
        return std::abs(length(offset) - surface.radius) < width ? std::optional(unit(offset)) : std::nullopt;
    }
    const std::uint32_t triangle = surface.tree->nearest(q, no_triangle, width).triangle;
    return triangle != no_triangle ? std::optional(normal_of(*surface.mesh, triangle)) : std::nullopt;
}

}  // namespace

Regions::Regions(const SceneDescription& scene, const SceneGeometry& geometry, double unit)
    : boundaries_(scene, geometry, unit), close_surfaces_(scene, geometry, boundaries_),
      outward_signs_(scene.objects.size(), 1) {
    for (const MediumBoundary& boundary : boundaries_.all()) {
        // Objects inside a horizon are reflected for the kernels, which reverses the order of the corners.
        const bool is_reflected = geometry.kernel_view()->surfaces[boundary.object].planes !=
                                  geometry.objects()[boundary.object].planes.data();
        outward_signs_[boundary.object] =
            boundary.mesh && is_reflected ? -boundary.outward_sign : boundary.outward_sign;
        append_to_list(names_, scene.objects[boundary.object].name);
        greatest_file_rounding_ = std::max(greatest_file_rounding_, boundary.file_rounding);
        has_contacts_ = has_contacts_ || close_surfaces_.are_close_to(boundary.object);
    }
    const bool has_touching_parts = check_agreement(scene, boundaries_, unit);
    has_contacts_ = has_contacts_ || has_touching_parts;
}

const MediumBoundary& Regions::boundary_of(std::uint32_t surface) const {
    return *std::find_if(boundaries_.all().begin(), boundaries_.all().end(),
                         [&](const MediumBoundary& candidate) { return candidate.object == surface; });
}

std::uint32_t Regions::medium_ahead(const Double3& q, const Double3& direction) const {
    constexpr double shift = 4, least_sine = 1e-4;  // the shift is in roundings
    Double3 ahead = q;
    for (const MediumBoundary& boundary : boundaries_.all()) {
        const double width = boundary.rounding + boundary.file_rounding;
        const auto normal = normal_near(boundary, q, width);
        if (!normal) continue;
        const double sine = dot(*normal, direction);
        const bool is_outward = sine > 0 || (!boundary.mesh && sine > -least_sine);
        const Double3 aside = scaled(*normal, is_outward ? 1 : -1);
        ahead = add(ahead, scaled(add(aside, direction), shift * width));
    }
    return medium_at(ahead);
}

std::uint32_t Regions::medium_beside(std::uint32_t surface, const Double3& q, const Double3& normal) const {
    // Contacts are not wider than one rounding, and twice the rounding of files.
    const double shift = 2 * boundary_of(surface).rounding + 4 * greatest_file_rounding_;
    return medium_at(add(q, scaled(normal, shift)));
}

double Regions::size_of(std::uint32_t surface) const { return boundary_of(surface).size; }

bool Regions::is_contact(std::uint32_t surface, std::uint32_t primitive, const Double3& q,
                         const Double3& normal) const {
    if (!has_contacts_) return false;
    const MediumBoundary& boundary = boundary_of(surface);
    return boundaries_.touch({&boundary, boundary.mesh ? primitive : no_triangle, q, normal});
}

FirstBoundary Regions::first_boundary(const Double3& q) const {
    constexpr int directions = 64;
    for (int i = 0; i < directions; ++i)
        if (const auto first = boundaries_.cast({q, spread_direction(i, directions)})) return *first;
    throw InputError("the medium at " + to_toml(q) +
                     ", relative to space.center, is unknown: on every ray from there, boundaries of different media "
                     "coincide. Move or remove one of the boundaries: " +
                     names_);
}

bool has_boundaries(const SceneDescription& scene) {
    return std::any_of(scene.objects.begin(), scene.objects.end(),
                       [](const ObjectDescription& object) { return object.material == Material::boundary; });
}

std::uint32_t check_camera_medium(const SceneDescription& scene, const Regions* regions, double unit) {
    const CameraDescription& camera = scene.camera;
    const FirstBoundary found =
        regions ? regions->first_boundary(subtract(camera.position, scene.space.center)) : FirstBoundary{};
    if (!camera.medium_index || *camera.medium_index == found.medium) return found.medium;
    std::string reason = regions ? "a straight ray from it crosses no boundary" : "the scene has no boundary";
    if (found.boundary)
        reason = "a straight ray from it first crosses object." + scene.objects[found.boundary->object].name +
                 " from " + (found.from_inside ? "inside" : "outside");
    const std::string& name = name_of_medium(scene, found.medium);
    throw InputError(*camera.medium_location,
                     "camera.medium = " + to_toml(camera.medium) + ", but the camera at camera.position = " +
                         to_toml(scaled(camera.position, unit)) + " is in " + to_toml(name) + ": " + reason +
                         "; state " + to_toml(name) + " or \"auto\", or move the camera");
}

}  // namespace kagero
