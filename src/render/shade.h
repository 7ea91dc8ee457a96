/// Ends of rays to pixels.
#pragma once

#include "film/film.h"
#include "render/camera.h"

#include <vector>

namespace kagero {

/// One ray of a pixel, from the camera to its end; positions relative to `space.center`.
struct Sighting {
    const RayEnd* end;
    CameraRay ray;
};

/// Writes what the film's layers want of a pixel's rays, at least one, into pixel (x, y) of the film.
void shade(const Plan& plan, const std::vector<Sighting>& rays, Film& film, std::uint32_t x, std::uint32_t y);

}  // namespace kagero
