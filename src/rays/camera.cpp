#include "rays/camera.h"

#include "scene/vector3.h"

#include <cmath>
#include <numbers>

namespace kagero {
namespace {

/// Longitude over the width, latitude over the height; the viewing direction is in the middle.
Double3 sphere_direction(const Plan& plan, double u, double v) {
    const double longitude = (u / plan.description().film.width - 0.5) * 2 * std::numbers::pi;
    const double latitude = (0.5 - v / plan.description().film.height) * std::numbers::pi;
    const View& view = plan.view;
    return add(scaled(add(scaled(view.forward, std::cos(longitude)), scaled(view.right, std::sin(longitude))),
                      std::cos(latitude)),
               scaled(view.down, -std::sin(latitude)));
}

/// Parallel rays, each seen by the observer at its own place of the picture's plane.
CameraRay parallel_ray(const Plan& plan, double u, double v) {
    const View& view = plan.view;
    const CameraRays& rays = view.camera;
    double q[3];
    for (std::size_t k = 0; k < 3; ++k)
        q[k] = rays.position[k] + (u - 0.5 * rays.width) * rays.right[k] + (v - 0.5 * rays.height) * rays.down[k];
    StartMap map;
    const Failure failure = observe(*plan.scene, view.observer, q, map);
    if (failure == Failure::no_rest_frame) return {plan.scene->space.start(q, view.forward), 1};
    if (failure != Failure::none) return {{{q[0], q[1], q[2]}, {0, 0, 0}, 0, failure, false, false}, 0};
    return ray_in_frame(map, q, view.forward);
}

}  // namespace

Double3 camera_direction(const Plan& plan, double u, double v) {
    if (plan.description().camera.type == CameraType::equirectangular) return sphere_direction(plan, u, v);
    const CameraRays& c = plan.view.camera;
    Double3 d;
    for (std::size_t k = 0; k < 3; ++k) d[k] = c.corner[k] + u * c.right[k] + v * c.down[k];
    return d;
}

CameraRay camera_ray(const Plan& plan, double u, double v) {
    const CameraRays& c = plan.view.camera;
    if (plan.description().camera.type == CameraType::orthographic) return parallel_ray(plan, u, v);
    const Double3 d = camera_direction(plan, u, v);
    if (plan.view.each_direction) return {plan.scene->space.start(c.position, d), 1};
    return ray_in_frame(c.start, c.position, d);
}

RayStart film_ray(const Plan& plan, double x, double y) {
    return camera_ray(plan, x, y).start;
}

RayStart pixel_ray(const Plan& plan, std::uint32_t x, std::uint32_t y) {
    return film_ray(plan, x + 0.5, y + 0.5);
}

}  // namespace kagero
