#include "plan/view.h"

#include "error.h"
#include "geometry/clearance/clearance.h"
#include "plan/names.h"
#include "scene/value.h"
#include "scene/vector3.h"
#include "spaces/charts.h"
#include "spaces/formula_space.h"
#include "spaces/rest_frame.h"
#include "spaces/velocity.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace kagero {
namespace {

/// Returns a lower bound on the distance of the camera from the nearest surface; infinity if there are no surfaces.
/// Throws InputError if the camera lies in a surface, because every ray would end at its start.
double distance_to_objects(const Scene& scene, const View& view) {
    const Geometry* geometry = scene.geometry->kernel_view();
    if (!geometry) return std::numeric_limits<double>::infinity();
    const double* eye = view.camera.start.position;
    const double diagonal = scene.geometry->diagonal(),
                 tolerance = 1e-14 * (diagonal + std::hypot(eye[0], eye[1], eye[2]));
    const double distance = distance_to_surfaces(*geometry, {eye[0], eye[1], eye[2]}, diagonal);
    if (distance > tolerance) return distance;
    throw InputError(
        scene.description.camera.position_location,
        position_of_camera(scene) +
            " lies in the surface of an object, or too close to it: its distance from every surface must exceed " +
            to_toml(tolerance * scene.unit) + ", the rounding error of its position");
}

/// Returns the view with the orientation and the pixel grid of the camera. Pixels are square, and row 0 is at the top.
View orient_camera(const Scene& scene) {
    const CameraDescription& camera = scene.description.camera;
    const FilmDescription& film = scene.description.film;
    View view;
    view.has_camera = true;
    view.observer = camera.observer;
    view.forward = unit(subtract(camera.look_at, camera.position));
    view.right = unit(cross(view.forward, camera.up));
    view.down = cross(view.forward, view.right);
    CameraRays& rays = view.camera;
    rays.width = film.width;
    rays.height = film.height;
    const double pixel = pixel_size(scene.description, 1);
    for (std::size_t k = 0; k < 3; ++k) {
        rays.right[k] = pixel * view.right[k];
        rays.down[k] = pixel * view.down[k];
        rays.corner[k] = view.forward[k] - 0.5 * film.width * rays.right[k] - 0.5 * film.height * rays.down[k];
        rays.position[k] = camera.position[k] - scene.description.space.center[k];
    }
    return view;
}

/// Returns the greatest |p|/p_t of the rays along the axes of an observer's rest frame; 0 if there is no p_t.
double greatest_start_momentum(const StartMap& map) {
    double greatest = 0;
    for (int j = 0; j < 3; ++j)
        for (const double sign : {1.0, -1.0}) {
            double p[4];
            for (int i = 0; i < 4; ++i) p[i] = sign * map.matrix[i][j] + map.offset[i];
            if (map.pt * p[3] > 0) greatest = std::max(greatest, std::hypot(p[0], p[1], p[2]) / std::abs(p[3]));
        }
    return greatest;
}

/// Returns true if the momenta of the map agree with the numerical solutions of H = H0, in twelve test directions.
bool is_exact(const StartMap& map, const Scene& scene, const View& view) {
    constexpr Double3 directions[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0},  {0, -1, 0},   {0, 0, 1},  {0, 0, -1},
                                      {1, 1, 1}, {-1, 2, 3}, {3, -1, 2}, {-2, -3, -1}, {2, 1, -3}, {-3, -1, 1}};
    constexpr double rounding = 1e-12;
    for (const Double3& d : directions) {
        const RayStart ray = scene.space.start(view.camera.position, d);
        if (ray.failure != Failure::none) return false;
        const RayStart mapped = ray_in_frame(map, d).start;
        const Double3 p{ray.p[0], ray.p[1], ray.p[2]}, mapped_p{mapped.p[0], mapped.p[1], mapped.p[2]};
        if (!(length(subtract(p, mapped_p)) <= rounding * length(p))) return false;
    }
    return true;
}

/// Returns true if a ray can start at the camera in at least one direction. Rays in other directions fail.
bool has_momentum_in_some_direction(const Scene& scene, const View& view) {
    constexpr int directions = 500;  // spread evenly over the sphere
    for (int i = 0; i < directions; ++i) {
        const double height = 2 * (i + 0.5) / directions - 1, width = std::sqrt(1 - height * height),
                     angle = 2.39996 * i;
        const Double3 d{width * std::cos(angle), width * std::sin(angle), height};
        if (scene.space.start(view.camera.position, d).failure == Failure::none) return true;
    }
    return false;
}

/// Sets the map from directions to momenta for a formula that is not a spacetime. The camera is at rest in the
/// coordinates. The map exists if H is quadratic in p; otherwise, sets View::solves_each_direction. Returns the failure
/// of the ray through the centre of the picture if there is no map.
Failure set_formula_map(const Scene& scene, View& view) {
    const RayStart center_ray = scene.space.start(view.camera.position, view.forward);
    view.camera.start = quadratic_map(*scene.description.space.formula, view.camera.position, center_ray.pt);
    view.solves_each_direction = !is_exact(view.camera.start, scene, view);
    if (!view.solves_each_direction || has_momentum_in_some_direction(scene, view)) return Failure::none;
    return center_ray.failure;
}

/// Sets the map from directions in the observer's rest frame at the camera's position to momenta. Returns the reason if
/// the map cannot exist.
Failure set_observer_map(const Scene& scene, View& view) {
    const Failure failure = make_camera_map(scene, view.observer, view.camera.position, view.camera.start);
    view.spacetime = scene.space.info().spacetime;
    if (!scene.description.space.formula) return failure;
    view.spacetime = failure != Failure::no_rest_frame;
    return view.spacetime ? failure : set_formula_map(scene, view);
}

/// Throws InputError if the scene states a velocity, or the frame of its sky, but the space is not a spacetime.
void require_spacetime(const Scene& scene, const View& view) {
    if (view.spacetime) return;
    const auto refuse = [](const VelocityDescription& velocity, const std::string& name) {
        throw InputError(velocity.location, name + " = " + text_of(velocity, {0, 0, 0}) +
                                                " is legal only in a spacetime, but this H is not that of light in a "
                                                "spacetime; remove the key");
    };
    const SceneDescription& description = scene.description;
    if (description.camera.velocity) refuse(*description.camera.velocity, "camera.velocity");
    if (description.space.sky_frame) refuse(*description.space.sky_frame, "space.sky_frame");
    for (const ObjectDescription& object : description.objects)
        if (object.velocity) refuse(*object.velocity, "object." + object.name + ".velocity");
}

/// Throws InputError for a camera whose stated velocity is impossible at its position.
[[noreturn]] void refuse_velocity(const Scene& scene, const View& view, Failure failure) {
    const VelocityDescription& velocity = *scene.description.camera.velocity;
    const auto& q = view.camera.position;
    const std::string where = "camera.velocity = " + text_of(velocity, q) + " at " + position_of_camera(scene);
    SpacetimeMatrix g;
    if (failure != Failure::no_observer || metric_at(scene.space, q, g) != Failure::none)
        throw InputError(velocity.location, where + ": " + describe(failure));
    throw InputError(velocity.location,
                     where + " is not slower than light: " + speed_limit(g, velocity_at(velocity, q)));
}

/// Throws InputError for an observer that cannot exist at the camera's position. The error refers to `camera.observer`
/// if the scene states it and another observer can exist there, else to `camera.position`.
[[noreturn]] void refuse_observer(const Scene& scene, View view, Failure failure) {
    const CameraDescription& camera = scene.description.camera;
    std::string others;
    for (std::size_t i = 0; i < observer_names().size(); ++i) {
        view.observer = static_cast<ObserverKind>(i);
        if (set_observer_map(scene, view) == Failure::none) append_to_list(others, name_of(view.observer));
    }
    const std::string reason = why_failed(scene, Precision::float64, failure), where = position_of_camera(scene);
    if (others.empty())
        throw InputError(camera.position_location, where + ": no ray can start at this position: " + reason);
    const std::string possible = "; possible observers at this position: " + others;
    if (camera.observer_location)
        throw InputError(*camera.observer_location, "camera.observer = \"" + name_of(camera.observer) +
                                                        "\" cannot exist at " + where + ": " + reason + possible);
    throw InputError(camera.position_location, where + ": the default camera.observer, \"" + name_of(camera.observer) +
                                                   "\", cannot exist at this position: " + reason + possible);
}

/// Throws InputError for a time rescaling factor that is not greater than 0 at the camera's position. The error refers
/// to `integrator.rescale` if the scene states it, else to `camera.position`.
[[noreturn]] void refuse_rescaling(const Scene& scene) {
    const IntegratorDescription& integrator = scene.description.integrator;
    if (!integrator.rescale_location)
        throw InputError(scene.description.camera.position_location,
                         position_of_camera(scene) + ": " + describe(Failure::bad_time_rescaling));
    throw InputError(*integrator.rescale_location, "integrator.rescale = \"" + integrator.rescale +
                                                       "\" is not greater than 0 at " + position_of_camera(scene));
}

/// Sets the lens of the view. Throws InputError if a surface may meet the lens, or if its observer is inside a horizon.
void set_lens(const Scene& scene, View& view) {
    const CameraDescription& camera = scene.description.camera;
    const std::string name = "camera.aperture_radius = " + to_toml(camera.aperture_radius * scene.unit);
    std::array<Double3, 3> axes{Double3{1, 0, 0}, Double3{0, 1, 0}, Double3{0, 0, 1}};
    SpacetimeMatrix g;
    double momentum_sign = 1;
    if (view.camera.start.ingoing)
        throw InputError(*camera.aperture_location,
                         name + " is not legal for an observer whose rays start in ingoing coordinates (" +
                             position_of_camera(scene) + "); state 0, or an observer that does not fall");
    if (metric_at(scene.space, view.camera.position, g, &momentum_sign) == Failure::none)
        axes = axes_in_coordinates(g, momentum_sign, view.camera.start);
    const auto displacement = [&](const Double3& d) {
        const Double3 unscaled = add(add(scaled(axes[0], d[0]), scaled(axes[1], d[1])), scaled(axes[2], d[2]));
        return scaled(unscaled, camera.aperture_radius);
    };
    view.lens_right = displacement(view.right);
    view.lens_down = displacement(view.down);
    const double radius = std::hypot(length(view.lens_right), length(view.lens_down));
    const Geometry* geometry = scene.geometry->kernel_view();
    const auto& eye = view.camera.position;
    const double distance =
        geometry ? distance_to_surfaces(*geometry, {eye[0], eye[1], eye[2]}, 2 * radius) : 2 * radius;
    if (radius < distance) return;
    throw InputError(*camera.aperture_location,
                     name + " is too great: the lens would reach the nearest surface, at the distance " +
                         to_toml(distance * scene.unit) + " from the camera; state less than " +
                         to_toml(camera.aperture_radius * scene.unit * distance / radius));
}

}  // namespace

double pixel_size(const SceneDescription& scene, double distance) {
    const double rows = scene.film.height;
    if (scene.camera.type == CameraType::orthographic) return scene.camera.height / rows;
    if (scene.camera.type == CameraType::equirectangular) return distance * std::numbers::pi / rows;
    return distance * 2 * std::tan(scene.camera.fov * std::numbers::pi / 360) / rows;
}

std::string why_no_orbit_family(const Scene& scene, const View& view) {
    if (!supported_angular_method(scene, false)) return "the space is not spherical, or is a formula";
    if (scene.description.camera.velocity) return "camera.velocity need not be along the line to the centre";
    const double* q = view.camera.position;
    if (std::hypot(q[0], q[1], q[2]) < 1e-6 * scene.limits.escape_radius) return "the camera is at the centre";
    if (scene.description.space.sky_frame) return "the distant observers of space.sky_frame move";
    return "";
}

Failure make_observer_map(const Scene& scene, ObserverKind observer, const double (&q)[3], StartMap& map) {
    const bool ingoing = starts_ingoing(scene.space, scene.limits.chart_radius, observer, q);
    const Failure failure = scene.space.observe(observer, q, ingoing, map);
    map.has_no_surfaces = !scene.geometry->kernel_view();
    return failure;
}

Failure make_camera_map(const Scene& scene, ObserverKind observer, const double (&q)[3], StartMap& map) {
    const auto& velocity = scene.description.camera.velocity;
    if (!velocity) return make_observer_map(scene, observer, q, map);
    // The observer may move inward, as a falling one does.
    const bool ingoing = starts_ingoing(scene.space, scene.limits.chart_radius, ObserverKind::falling, q);
    const Failure failure = make_moving_map(scene.space, q, velocity_at(*velocity, q), ingoing, map);
    map.has_no_surfaces = !scene.geometry->kernel_view();
    return failure;
}

// Computes the same sums in the same order as the camera of the kernels, so that both generate bitwise equal rays.
CameraRay ray_in_frame(const StartMap& map, const Double3& d) {
    const auto row = [&](int i) { return map.metric[i][0] * d[0] + map.metric[i][1] * d[1] + map.metric[i][2] * d[2]; };
    const double inverse_length = 1 / std::sqrt(d[0] * row(0) + d[1] * row(1) + d[2] * row(2));
    const double n[3] = {d[0] * inverse_length, d[1] * inverse_length, d[2] * inverse_length};
    double p[4];
    for (int i = 0; i < 4; ++i)
        p[i] = map.matrix[i][0] * n[0] + map.matrix[i][1] * n[1] + map.matrix[i][2] * n[2] + map.offset[i];
    const bool is_scaled = map.pt * p[3] > 0, captured = map.pt != 0 && map.has_no_surfaces && !is_scaled;
    const double scale = is_scaled ? map.pt / p[3] : 1;
    RayStart start{{}, {p[0] * scale, p[1] * scale, p[2] * scale}, p[3] * scale, Failure::none, captured, false};
    std::copy_n(map.position, 3, start.q);
    start.ingoing = map.ingoing;
    return {start, scale};
}

View make_camera_view(const Scene& scene, const Options& options) {
    View view = orient_camera(scene);
    const FilmDescription& film = scene.description.film;
    view.window = options.crop.x1 ? options.crop : Tile{0, 0, film.width, film.height};
    const Failure failure = set_observer_map(scene, view);
    require_spacetime(scene, view);
    if (failure != Failure::none && scene.description.camera.velocity) refuse_velocity(scene, view, failure);
    if (failure != Failure::none) refuse_observer(scene, view, failure);
    if (has_invalid_time_rescaling(scene, view.camera.position)) refuse_rescaling(scene);
    if (has_invalid_bounds(scene, view.camera.position))
        throw InputError(scene.description.camera.position_location,
                         position_of_camera(scene) + ": " + describe(Failure::invalid_bounds));
    view.camera.clearance = distance_to_objects(scene, view);
    if (scene.description.camera.aperture_radius > 0) set_lens(scene, view);
    return view;
}

bool needs_double(const Scene& scene, double momentum) {
    return scene.space.info().spacetime && momentum * double(std::numeric_limits<float>::epsilon()) > 1e-3;
}

bool camera_needs_double(const Scene& scene, const View& view) {
    // p depends linearly on the direction, except for the division by p_t. The momentum of other directions is
    // therefore not much larger than along the axes.
    return needs_double(scene, greatest_start_momentum(view.camera.start));
}

bool kernel_makes_rays(const Scene& scene, const View& view) {
    const SceneDescription& description = scene.description;
    return view.has_camera && description.camera.type == CameraType::perspective && description.film.spp == 1 &&
           !view.solves_each_direction && description.camera.aperture_radius == 0;
}

std::string position_of_camera(const Scene& scene) {
    return "camera.position = " + to_toml(scaled(scene.description.camera.position, scene.unit));
}

}  // namespace kagero
