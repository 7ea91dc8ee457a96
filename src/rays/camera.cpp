#include "rays/camera.h"

#include "error.h"
#include "plan/formula_space.h"
#include "geometry/clearance.h"
#include "scene/value.h"
#include "scene/vector3.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace kagero {
namespace {

/// "camera.position = [x, y, z]", in the scene's lengths.
std::string position_of_camera(const Plan& plan) {
    return "camera.position = " + written(scaled(plan.scene.camera.position, plan.unit));
}

/// How far the camera is from the surface of an object, or a number less than that. Refuses one that lies in it: every ray would start there.
double distance_to_objects(const Plan& plan) {
    const Geometry* geometry = plan.geometry->kernel_view();
    if (!geometry) return std::numeric_limits<double>::infinity();
    const double* eye = plan.camera.position;
    const double most = plan.geometry->diagonal(), tolerance = 1e-6 * most;
    const double distance = distance_to_surfaces(*geometry, {eye[0], eye[1], eye[2]}, most);
    if (distance > tolerance) return distance;
    throw InputError(plan.scene.camera.position_place,
                     position_of_camera(plan) + " lies in the surface of an object, or too close to it for a scene of this size: it must be farther than " +
                         written(tolerance * plan.unit) + " from every surface, a millionth of the extent of all objects");
}

/// Square pixels, row 0 on top.
void aim(Plan& plan) {
    const CameraDescription& camera = plan.scene.camera;
    const FilmDescription& film = plan.scene.film;
    View& view = plan.view;
    view.observer = observer_named(camera.observer);
    view.forward = unit(subtract(camera.look_at, camera.position));
    view.right = unit(cross(view.forward, camera.up));
    view.down = cross(view.forward, view.right);
    CameraRays& rays = plan.camera;
    rays.width = film.width, rays.height = film.height;
    const double pixel = pixel_size(plan.scene, 1);
    for (std::size_t k = 0; k < 3; ++k) {
        rays.right[k] = pixel * view.right[k], rays.down[k] = pixel * view.down[k];
        rays.corner[k] = view.forward[k] - 0.5 * film.width * rays.right[k] - 0.5 * film.height * rays.down[k];
    }
}

/// Longitude over the width, latitude over the height; the viewing direction is in the middle.
Double3 sphere_direction(const Plan& plan, double u, double v) {
    const double longitude = (u / plan.scene.film.width - 0.5) * 2 * std::numbers::pi;
    const double latitude = (0.5 - v / plan.scene.film.height) * std::numbers::pi;
    const View& view = plan.view;
    return add(
        scaled(add(scaled(view.forward, std::cos(longitude)), scaled(view.right, std::sin(longitude))), std::cos(latitude)),
        scaled(view.down, -std::sin(latitude)));
}

/// Parallel rays, each seen by the observer at its own place of the picture's plane.
CameraRay parallel_ray(const Plan& plan, double u, double v) {
    const CameraRays& rays = plan.camera;
    double q[3];
    for (std::size_t k = 0; k < 3; ++k)
        q[k] = rays.position[k] + (u - 0.5 * rays.width) * rays.right[k] + (v - 0.5 * rays.height) * rays.down[k];
    StartMap map;
    const Failure failure = observe(plan, plan.view.observer, q, map);
    if (failure == Failure::no_rest_frame) return {formula_ray(plan, q, plan.view.forward), 1};
    if (failure != Failure::none) return {{{q[0], q[1], q[2]}, {0, 0, 0}, 0, failure, false, false}, 0};
    return ray_in_frame(map, q, plan.view.forward);
}

/// The greatest momentum, over p_t, that an observer gives to a direction along an axis.
double start_momentum(const StartMap& map) {
    double greatest = 0;
    for (int j = 0; j < 3; ++j)
        for (const double sign : {1.0, -1.0}) {
            double p[4];
            for (int i = 0; i < 4; ++i) p[i] = sign * map.matrix[i][j] + map.offset[i];
            if (map.pt > 0 && p[3] > 0) greatest = std::max(greatest, std::hypot(p[0], p[1], p[2]) / p[3]);
        }
    return greatest;
}

/// The map that the plan's observer gives to the camera where it stands.
Failure place_observer(Plan& plan, StartMap& map) {
    const Failure failure = observe(plan, plan.view.observer, plan.camera.position, map);
    if (!plan.scene.space.formula) return failure;
    plan.spacetime = failure != Failure::no_rest_frame;
    return plan.spacetime ? failure : place_formula_camera(plan, map);
}

/// Blames the observer where the scene states it and another could be at the camera's place, else that place.
[[noreturn]] void refuse_observer(Plan& plan, Failure failure) {
    const CameraDescription& camera = plan.scene.camera;
    std::string others;
    for (const std::string& name : observer_names()) {
        StartMap map;
        plan.view.observer = observer_named(name);
        if (place_observer(plan, map) == Failure::none) enumerate(others, name);
    }
    const std::string why = describe(failure) + (others.empty() ? std::string() : "; here can be: " + others);
    if (others.empty() || !camera.observer_place)
        throw InputError(camera.position_place, position_of_camera(plan) + ": no " + camera.observer + " observer can be here: " + why);
    throw InputError(*camera.observer_place, "camera.observer = \"" + camera.observer + "\" cannot be at " + position_of_camera(plan) + ": " + why);
}

/// Blames what time is rescaled by, where the scene states it, else the place.
[[noreturn]] void refuse_rescaling(const Plan& plan) {
    const IntegratorDescription& integrator = plan.scene.integrator;
    if (!integrator.rescale_place)
        throw InputError(plan.scene.camera.position_place, position_of_camera(plan) + ": " + describe(Failure::no_pace));
    throw InputError(*integrator.rescale_place, "integrator.rescale = \"" + integrator.rescale + "\" is not greater than 0 at " + position_of_camera(plan));
}

}  // namespace

double pixel_size(const SceneDescription& scene, double distance) {
    const double rows = scene.film.height;
    if (scene.camera.type == "orthographic") return scene.camera.height / rows;
    if (scene.camera.type == "equirectangular") return distance * std::numbers::pi / rows;
    return distance * 2 * std::tan(scene.camera.fov * std::numbers::pi / 360) / rows;
}

bool camera_needs_double(const Plan& plan) {
    // p depends on the direction linearly, but for the division by p_t: no corner's momentum is larger by much.
    return needs_double(plan, start_momentum(plan.camera.start));
}

void place_camera(Plan& plan) {
    const SceneDescription& scene = plan.scene;
    aim(plan);
    for (std::size_t k = 0; k < 3; ++k) plan.camera.position[k] = scene.camera.position[k] - scene.space.center[k];
    const Failure failure = place_observer(plan, plan.camera.start);
    if (failure != Failure::none) refuse_observer(plan, failure);
    if (lacks_pace(plan, plan.camera.position)) refuse_rescaling(plan);
    const auto refuse = [&](Failure why) { throw InputError(scene.camera.position_place, position_of_camera(plan) + ": " + describe(why)); };
    if (lacks_bounds(plan, plan.camera.position)) refuse(Failure::no_bounds);
    if (camera_needs_double(plan)) refuse(Failure::needs_double);
    plan.camera.clear = distance_to_objects(plan);
    if (kernel_makes_rays(plan)) plan.job.camera = &plan.camera;
}

Failure observe(const Plan& plan, ObserverKind kind, const double (&q)[3], StartMap& map) {
    const Failure failure = plan.module->observe(plan.hamiltonian, plan.parameters.data(), kind, q, &map);
    map.sky_alone = !plan.geometry->kernel_view();
    return failure;
}

// The same sums in the same order as the kernels' own camera, so that both make the same rays to the last bit.
CameraRay ray_in_frame(const StartMap& map, const double (&q)[3], const Double3& d) {
    const auto row = [&](int i) { return map.metric[i][0] * d[0] + map.metric[i][1] * d[1] + map.metric[i][2] * d[2]; };
    const double inverse = 1 / std::sqrt(d[0] * row(0) + d[1] * row(1) + d[2] * row(2));
    const double n[3] = {d[0] * inverse, d[1] * inverse, d[2] * inverse};
    double p[4];
    for (int i = 0; i < 4; ++i)
        p[i] = map.matrix[i][0] * n[0] + map.matrix[i][1] * n[1] + map.matrix[i][2] * n[2] + map.offset[i];
    const bool captured = map.pt > 0 && map.sky_alone && !(p[3] > 0);
    const double scale = map.pt > 0 && p[3] > 0 ? map.pt / p[3] : 1;
    return {{{q[0], q[1], q[2]}, {p[0] * scale, p[1] * scale, p[2] * scale}, p[3] * scale, Failure::none, captured, false}, scale};
}

Double3 camera_direction(const Plan& plan, double u, double v) {
    if (plan.scene.camera.type == "equirectangular") return sphere_direction(plan, u, v);
    const CameraRays& c = plan.camera;
    Double3 d;
    for (std::size_t k = 0; k < 3; ++k) d[k] = c.corner[k] + u * c.right[k] + v * c.down[k];
    return d;
}

CameraRay camera_ray(const Plan& plan, double u, double v) {
    const CameraRays& c = plan.camera;
    if (plan.scene.camera.type == "orthographic") return parallel_ray(plan, u, v);
    const Double3 d = camera_direction(plan, u, v);
    if (plan.each_direction) return {formula_ray(plan, c.position, d), 1};
    return ray_in_frame(c.start, c.position, d);
}

bool kernel_makes_rays(const Plan& plan) {
    return plan.scene.camera.type == "perspective" && plan.scene.film.spp == 1 && !plan.each_direction;
}

}  // namespace kagero
