/// Ends of rays to pixels.
#pragma once

#include "film/film.h"
#include "render/camera.h"

#include <span>
#include <vector>

namespace kagero {

/// One ray of a pixel, from the camera to its end; positions relative to `space.center`.
struct Sighting {
    const RayEnd* end;
    CameraRay ray;
};

/// The piece of the sky, and of a wormhole's far sky, that each ray of a pixel stands for.
struct SkyFootprints {
    Footprint near, far;
};

/// Writes what the film's layers want of a pixel's rays, at least one, into pixel (x, y) of the film.
void shade(const Plan& plan, std::span<const Sighting> rays, const SkyFootprints& footprints, Film& film, std::uint32_t x,
           std::uint32_t y);

}  // namespace kagero
