/// The camera of a picture, and the map from directions in its observer's rest frame to momenta.
#pragma once

#include "appearance/pixel_sample.h"
#include "plan/scene.h"

namespace kagero {

/// The view of a picture. Unit vectors are in the rest frame of the observer; positions are relative to `space.center`.
struct View {
    bool has_camera = false;  ///< False: for a ray list, which contains its ray starts.
    ObserverKind observer = ObserverKind::static_;
    Double3 forward{}, right{}, down{};
    CameraRays camera{};
    bool spacetime = false;  ///< True if observers have rest frames and light has a frequency.
    /// True if no map from directions to momenta exists. The momentum of each ray is then solved for numerically.
    bool solves_each_direction = false;
    Tile window{};  ///< Pixels to render.
    /// Displacements dq from the centre of a thin lens to its edge, along `right` and `down`; zero without a lens. The
    /// lens is a disk in the rest frame of the observer.
    Double3 lens_right{}, lens_down{};
    /// Displacement of all rays in pixels, which `camera` contains already, except for an equirectangular camera.
    std::array<double, 2> displacement{};
    std::uint32_t medium = 0;  ///< Medium around the camera (Plan::medium).
};

/// Returns the edge length of a pixel at this distance from the camera. At distance 1, it is also the angle of the
/// pixel in radians, except for an orthographic camera, whose pixels have the same size at every distance.
double pixel_size(const SceneDescription& scene, double distance);

/// Sets `map` to the map from directions in the rest frame of an observer at q to momenta. Returns Failure::none, or
/// the reason why the observer cannot exist at q.
Failure make_observer_map(const Scene& scene, ObserverKind observer, const double (&q)[3], StartMap& map);

/// Sets `map` to the map of make_observer_map for the scene's camera at q. Its velocity is the stated one, or else that
/// of `observer`.
Failure make_camera_map(const Scene& scene, ObserverKind observer, const double (&q)[3], StartMap& map);

/// Returns the reason why the end of a ray depends on more than the angle between its first direction, in the rest
/// frame of the camera's observer, and the line to the centre of the space; "" if it does not.
std::string why_no_orbit_family(const Scene& scene, const View& view);

/// Returns the ray that starts at the map's position with direction d, of any length, in its rest frame.
CameraRay ray_in_frame(const StartMap& map, const Double3& d);

/// Returns the view of the scene's camera. Throws InputError if the observer cannot exist at the camera's position, or
/// if no ray can start there.
View make_camera_view(const Scene& scene, const Options& options);

/// Returns true if float cannot represent H accurately. `momentum` is |p|/p_t. The terms of H are of the order |p|²,
/// and their sum must be accurate to a thousandth of |p| (p_t = 1).
bool needs_double(const Scene& scene, double momentum);
/// Returns needs_double for the greatest momentum of the camera's rays.
bool camera_needs_double(const Scene& scene, const View& view);

/// Returns true if the kernels can generate the camera's rays. The camera must be a perspective pinhole camera with one
/// ray per pixel, and a map from directions to momenta must exist.
bool kernel_makes_rays(const Scene& scene, const View& view);

/// Returns the text "camera.position = [x, y, z]", in lengths of the scene file.
std::string position_of_camera(const Scene& scene);

}  // namespace kagero
