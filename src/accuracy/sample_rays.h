/// Sample rays: camera rays through a coarse grid of film pixels, on which errors are measured.
#pragma once

#include "plan/plan.h"

namespace kagero {

/// Sampled camera rays and their neighbours.
struct SampleRays {
    std::uint32_t width = 0, height = 0;  ///< Size of the grid, at most the size of the film; 0 without a grid.
    std::vector<RayStart> starts;
    std::vector<std::array<double, 2>> pixels;  ///< Point (x, y) of each ray on the film, in pixels.
    /// Two neighbours of each ray, turned by `neighbour_angle` to the right and downward. The conditioning of the ray
    /// is measured with them.
    std::vector<RayStart> right, below;
    double neighbour_angle = 0;  ///< Angle to the neighbours in radians; for an orthographic camera, a distance.
    double pixel_angle = 0;  ///< Size of a film pixel at the centre of the picture, in the unit of `neighbour_angle`.
};

/// Returns the centres of film pixels on a grid of at most width × height, in pixels. Rays that are close in the list
/// are close in the picture.
std::vector<std::array<double, 2>> sample_pixels(const FilmDescription& film, std::uint32_t width,
                                                 std::uint32_t height);

/// Returns the camera rays through points of the film, and their neighbours.
SampleRays sample_rays(const Plan& plan, std::vector<std::array<double, 2>> pixels);

/// Returns the camera rays, and their neighbours, of a grid of at most width × height pixels that covers the film.
SampleRays sample_rays(const Plan& plan, std::uint32_t width, std::uint32_t height);

}  // namespace kagero
