#include "plan/view.h"

#include "error.h"
#include "geometry/clearance.h"
#include "plan/formula_space.h"
#include "plan/names.h"
#include "scene/value.h"
#include "scene/vector3.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace kagero {
namespace {

/// How far the camera is from the surface of an object, or a number less than that. Refuses one that lies in it: every
/// ray would start there.
double distance_to_objects(const Scene& scene, const View& view) {
    const Geometry* geometry = scene.geometry->kernel_view();
    if (!geometry) return std::numeric_limits<double>::infinity();
    const double* eye = view.camera.position;
    const double most = scene.geometry->diagonal(), tolerance = 1e-6 * most;
    const double distance = distance_to_surfaces(*geometry, {eye[0], eye[1], eye[2]}, most);
    if (distance > tolerance) return distance;
    throw InputError(
        scene.description.camera.position_place,
        position_of_camera(scene) +
            " lies in the surface of an object, or too close to it for a scene of this size: it must be farther than " +
            written(tolerance * scene.unit) + " from every surface, a millionth of the extent of all objects");
}

/// Square pixels, row 0 on top.
View aim(const Scene& scene) {
    const CameraDescription& camera = scene.description.camera;
    const FilmDescription& film = scene.description.film;
    View view;
    view.has_camera = true;
    view.observer = camera.observer;
    view.forward = unit(subtract(camera.look_at, camera.position));
    view.right = unit(cross(view.forward, camera.up));
    view.down = cross(view.forward, view.right);
    CameraRays& rays = view.camera;
    rays.width = film.width, rays.height = film.height;
    const double pixel = pixel_size(scene.description, 1);
    for (std::size_t k = 0; k < 3; ++k) {
        rays.right[k] = pixel * view.right[k], rays.down[k] = pixel * view.down[k];
        rays.corner[k] = view.forward[k] - 0.5 * film.width * rays.right[k] - 0.5 * film.height * rays.down[k];
        rays.position[k] = camera.position[k] - scene.description.space.center[k];
    }
    return view;
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

/// Whether the map gives the momenta that solving for them gives, in all directions that are tried.
bool serves(const StartMap& map, const Scene& scene, const View& view) {
    constexpr Double3 directions[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0},  {0, -1, 0}, {0, 0, 1},   {0, 0, -1},
                                      {1, 1, 1}, {-1, 2, 3}, {3, -1, 2}, {-2, -3, -1}, {2, 1, -3}, {-3, -1, 1}};
    constexpr double rounding = 1e-12;
    for (const Double3& d : directions) {
        const RayStart ray = scene.space.start(view.camera.position, d);
        if (ray.failure != Failure::none) return false;
        const RayStart mapped = ray_in_frame(map, view.camera.position, d).start;
        const Double3 p{ray.p[0], ray.p[1], ray.p[2]}, other{mapped.p[0], mapped.p[1], mapped.p[2]};
        if (!(length(subtract(p, other)) <= rounding * length(p))) return false;
    }
    return true;
}

/// For a camera at rest in the coordinates of what is no spacetime: a map from directions to momenta if H is quadratic
/// in p; else View::each_direction is set.
Failure place_formula_camera(const Scene& scene, View& view) {
    const RayStart middle = scene.space.start(view.camera.position, view.forward);
    view.camera.start = quadratic_map(*scene.description.space.formula, view.camera.position, middle.pt);
    view.each_direction = !serves(view.camera.start, scene, view);
    return view.each_direction ? middle.failure : Failure::none;
}

/// Gives the view the map of its observer at the camera's place.
Failure place_observer(const Scene& scene, View& view) {
    const Failure failure = observe(scene, view.observer, view.camera.position, view.camera.start);
    view.spacetime = scene.space.info().spacetime;
    if (!scene.description.space.formula) return failure;
    view.spacetime = failure != Failure::no_rest_frame;
    return view.spacetime ? failure : place_formula_camera(scene, view);
}

/// Blames the observer where the scene states it and another could be at the camera's place, else that place.
[[noreturn]] void refuse_observer(const Scene& scene, View view, Failure failure) {
    const CameraDescription& camera = scene.description.camera;
    std::string others;
    for (std::size_t i = 0; i < observer_names().size(); ++i) {
        view.observer = static_cast<ObserverKind>(i);
        if (place_observer(scene, view) == Failure::none) enumerate(others, name_of(view.observer));
    }
    const std::string& name = name_of(camera.observer);
    const std::string why = describe(failure) + (others.empty() ? std::string() : "; here can be: " + others);
    if (others.empty() || !camera.observer_place)
        throw InputError(camera.position_place,
                         position_of_camera(scene) + ": no " + name + " observer can be here: " + why);
    throw InputError(*camera.observer_place,
                     "camera.observer = \"" + name + "\" cannot be at " + position_of_camera(scene) + ": " + why);
}

/// Blames what time is rescaled by, where the scene states it, else the place.
[[noreturn]] void refuse_rescaling(const Scene& scene) {
    const IntegratorDescription& integrator = scene.description.integrator;
    if (!integrator.rescale_place)
        throw InputError(scene.description.camera.position_place,
                         position_of_camera(scene) + ": " + describe(Failure::no_pace));
    throw InputError(*integrator.rescale_place, "integrator.rescale = \"" + integrator.rescale +
                                                    "\" is not greater than 0 at " + position_of_camera(scene));
}

}  // namespace

double pixel_size(const SceneDescription& scene, double distance) {
    const double rows = scene.film.height;
    if (scene.camera.type == CameraType::orthographic) return scene.camera.height / rows;
    if (scene.camera.type == CameraType::equirectangular) return distance * std::numbers::pi / rows;
    return distance * 2 * std::tan(scene.camera.fov * std::numbers::pi / 360) / rows;
}

Failure observe(const Scene& scene, ObserverKind observer, const double (&q)[3], StartMap& map) {
    const Failure failure = scene.space.observe(observer, q, map);
    map.sky_alone = !scene.geometry->kernel_view();
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
    return {
        {{q[0], q[1], q[2]}, {p[0] * scale, p[1] * scale, p[2] * scale}, p[3] * scale, Failure::none, captured, false},
        scale};
}

View place_camera(const Scene& scene, const Options& options) {
    View view = aim(scene);
    const FilmDescription& film = scene.description.film;
    view.window = options.crop.x1 ? options.crop : Tile{0, 0, film.width, film.height};
    const Failure failure = place_observer(scene, view);
    if (failure != Failure::none) refuse_observer(scene, view, failure);
    if (lacks_pace(scene, view.camera.position)) refuse_rescaling(scene);
    if (lacks_bounds(scene, view.camera.position))
        throw InputError(scene.description.camera.position_place,
                         position_of_camera(scene) + ": " + describe(Failure::no_bounds));
    view.camera.clear = distance_to_objects(scene, view);
    return view;
}

bool needs_double(const Scene& scene, double momentum) {
    return scene.space.info().spacetime && momentum * double(std::numeric_limits<float>::epsilon()) > 1e-3;
}

bool camera_needs_double(const Scene& scene, const View& view) {
    // p depends on the direction linearly, but for the division by p_t: no corner's momentum is larger by much.
    return needs_double(scene, start_momentum(view.camera.start));
}

bool kernel_makes_rays(const Scene& scene, const View& view) {
    const SceneDescription& description = scene.description;
    return view.has_camera && description.camera.type == CameraType::perspective && description.film.spp == 1 &&
           !view.each_direction;
}

std::string position_of_camera(const Scene& scene) {
    return "camera.position = " + written(scaled(scene.description.camera.position, scene.unit));
}

}  // namespace kagero
