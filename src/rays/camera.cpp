#include "rays/camera.h"

#include "scene/vector3.h"

#include <cmath>
#include <numbers>

namespace kagero {
namespace {

/// Returns the direction of the ray through the point (x, y) of an equirectangular picture. Longitude and latitude are
/// linear in x and y. The viewing direction is in the middle of the picture.
Double3 equirectangular_direction(const Plan& plan, double x, double y) {
    x += plan.view.displacement[0];
    y += plan.view.displacement[1];
    const double longitude = (x / plan.description().film.width - 0.5) * 2 * std::numbers::pi;
    const double latitude = (0.5 - y / plan.description().film.height) * std::numbers::pi;
    const View& view = plan.view;
    return add(scaled(add(scaled(view.forward, std::cos(longitude)), scaled(view.right, std::sin(longitude))),
                      std::cos(latitude)),
               scaled(view.down, -std::sin(latitude)));
}

/// Returns the ray through the point (x, y) of an orthographic camera, whose rays are parallel. Each ray starts at its
/// point of the picture plane, and an observer at that point measures its direction.
CameraRay orthographic_ray(const Plan& plan, double x, double y) {
    const View& view = plan.view;
    const CameraRays& c = view.camera;
    double q[3];
    for (std::size_t k = 0; k < 3; ++k)
        q[k] = c.position[k] + (x - 0.5 * c.width) * c.right[k] + (y - 0.5 * c.height) * c.down[k];
    const Scene& scene = *plan.medium(view.medium).scene;
    StartMap map;
    const Failure failure = make_camera_map(scene, view.observer, q, map);
    if (failure == Failure::no_rest_frame) return {scene.space.start(q, view.forward), 1};
    if (failure != Failure::none) return {{{q[0], q[1], q[2]}, {0, 0, 0}, 0, failure, false, false}, 0};
    return ray_in_frame(map, view.forward);
}

/// Returns the ray through the point (x, y). The medium in which it starts is not set.
CameraRay ray_through(const Plan& plan, double x, double y) {
    const CameraRays& c = plan.view.camera;
    if (plan.description().camera.type == CameraType::orthographic) return orthographic_ray(plan, x, y);
    const Double3 d = camera_direction(plan, x, y);
    if (plan.view.solves_each_direction) return {plan.medium(plan.view.medium).scene->space.start(c.position, d), 1};
    return ray_in_frame(c.start, d);
}

}  // namespace

Plan with_displaced_rays(Plan plan, double x, double y) {
    plan.view.displacement = {x, y};
    CameraRays& c = plan.view.camera;
    double* const origin = plan.description().camera.type == CameraType::orthographic ? c.position : c.corner;
    for (std::size_t k = 0; k < 3; ++k) origin[k] += x * c.right[k] + y * c.down[k];
    return plan;
}

Double3 camera_direction(const Plan& plan, double x, double y) {
    if (plan.description().camera.type == CameraType::equirectangular) return equirectangular_direction(plan, x, y);
    const CameraRays& c = plan.view.camera;
    Double3 d;
    for (std::size_t k = 0; k < 3; ++k) d[k] = c.corner[k] + x * c.right[k] + y * c.down[k];
    return d;
}

CameraRay camera_ray(const Plan& plan, double x, double y) {
    CameraRay ray = ray_through(plan, x, y);
    ray.start.medium = plan.view.medium;
    return ray;
}

CameraRay lens_ray(const Plan& plan, double x, double y, const std::array<double, 2>& lens) {
    const View& view = plan.view;
    const CameraDescription& camera = plan.description().camera;
    const Double3 displacement = add(scaled(view.lens_right, lens[0]), scaled(view.lens_down, lens[1])),
                  offset = scaled(add(scaled(view.right, lens[0]), scaled(view.down, lens[1])), camera.aperture_radius),
                  d = subtract(scaled(camera_direction(plan, x, y), camera.focus_distance), offset);
    double q[3];
    for (std::size_t k = 0; k < 3; ++k) q[k] = view.camera.position[k] + displacement[k];
    const Scene& scene = *plan.medium(view.medium).scene;
    StartMap map;
    const Failure failure = make_camera_map(scene, view.observer, q, map);
    CameraRay ray{{{q[0], q[1], q[2]}, {0, 0, 0}, 0, failure, false, false}, 0};
    if (failure == Failure::no_rest_frame) ray = {scene.space.start(q, d), 1};
    else if (failure == Failure::none) ray = ray_in_frame(map, d);
    ray.start.medium = view.medium;
    return ray;
}

RayStart camera_ray_start(const Plan& plan, double x, double y) {
    return camera_ray(plan, x, y).start;
}

RayStart pixel_ray_start(const Plan& plan, std::uint32_t x, std::uint32_t y) {
    return camera_ray_start(plan, x + 0.5, y + 0.5);
}

}  // namespace kagero
