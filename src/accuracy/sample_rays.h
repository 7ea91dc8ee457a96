/// Rays of the scene's camera on a coarse grid of its pixels: what a study of error follows.
#pragma once

#include "plan/plan.h"

namespace kagero {

struct SampleRays {
    std::uint32_t width = 0, height = 0;  ///< of the grid; never finer than the film
    std::vector<RayStart> starts;
    std::vector<std::array<double, 2>> pixels;  ///< where on the film each ray starts, in pixels
    /// The same rays turned to the right and downward by `turn`: how their ends move apart is their conditioning.
    std::vector<RayStart> right, below;
    double turn = 0;         ///< radians; of an orthographic camera a length
    double pixel_angle = 0;  ///< of the film's pixels, in the middle of the picture; in the same
};

/// The middles of the film's pixels on a grid of at most width × height, in pixels; neighbours in the list are
/// neighbours in the picture.
std::vector<std::array<double, 2>> sample_pixels(const FilmDescription& film, std::uint32_t width,
                                                 std::uint32_t height);

/// A grid of at most width × height pixels spread over the whole film.
SampleRays sample_rays(const Plan& plan, std::uint32_t width, std::uint32_t height);

}  // namespace kagero
