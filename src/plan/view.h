/// Where the camera stands and looks, and the map from directions in its observer's rest frame to momenta.
#pragma once

#include "appearance/pixel_sample.h"
#include "plan/scene.h"

namespace kagero {

/// Unit vectors are in the rest frame of the observer; positions are relative to `space.center`.
struct View {
    bool has_camera = false;      ///< false: of a ray list, which brings its own starts
    ObserverKind observer = ObserverKind::static_;
    Double3 forward{}, right{}, down{};
    CameraRays camera{};
    bool spacetime = false;       ///< observers have rest frames, and light has a frequency
    bool each_direction =
        false;  ///< no map from directions to momenta exists: the momentum of each direction is solved for
    Tile window{};                ///< the pixels that are asked for
};

/// How large a pixel of the scene's camera is at a distance: a length; at distance 1 an angle.
double pixel_size(const SceneDescription& scene, double distance);

/// The rest frame of an observer at q.
Failure observe(const Scene& scene, ObserverKind observer, const double (&q)[3], StartMap& map);

/// A ray in direction d, of any length, of the rest frame that `map` belongs to.
CameraRay ray_in_frame(const StartMap& map, const double (&q)[3], const Double3& d);

/// Places the scene's camera. Throws InputError where no observer can be, or where no ray can start.
View place_camera(const Scene& scene, const Options& options);

/// Whether float would lose H: its terms are |p|², in units of p_t, and what must be left of them is |p|. A thousandth
/// of that may go.
bool needs_double(const Scene& scene, double momentum);
/// The same for the camera's rays.
bool camera_needs_double(const Scene& scene, const View& view);

/// Whether the kernels can make the camera's rays themselves: one through the middle of each pixel of a perspective
/// camera.
bool kernel_makes_rays(const Scene& scene, const View& view);

/// "camera.position = [x, y, z]", in the lengths of the scene as written.
std::string position_of_camera(const Scene& scene);

}  // namespace kagero
