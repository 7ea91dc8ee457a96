/// The data of one ray from which its pixel is computed.
#pragma once

#include "appearance/path_state.h"
#include "appearance/sky_view.h"

namespace kagero {

/// Start of a camera ray, and the frequency of its light in the rest frame of the camera's observer. The frequency is
/// p · u, with the momentum p of `start` and the 4-velocity u of the observer. It is 1 in spaces without rest frames,
/// and 0 if the ray cannot start.
struct CameraRay {
    RayStart start;
    double frequency;
};

/// Estimated errors of a ray end, in pixels of the film; NaN if unknown.
struct EndError {
    double position = 0;  ///< Error caused by method, step and precision together.
    double rounding = 0;  ///< Bound on the part of this error that rounding causes.
};

/// One ray of a pixel.
struct PixelSample {
    const RayEnd* end = nullptr;
    const CameraRay* ray = nullptr;   ///< Set only if a layer or an object needs it.
    const EndError* error = nullptr;  ///< Set only if a layer needs it.
    Patch patch{};                    ///< Patch on the surface that the ray hits.
    SkyView sky{};                    ///< Sky and direction if the ray escapes.
    Float3 source_color{};            ///< Colour of the sky, or of a black body, where the ray ends.
    Footprint footprint{};            ///< Footprint on the sky if the ray escapes; set only if a layer needs it.
    const PathState* path = nullptr;  ///< Null if all rays end at the first surface.
    bool interpolated = false;        ///< True if the end is interpolated between those of other rays.
    std::uint32_t group = 0;          ///< Number of the ray's group in its block (group_by_path in footprint.h).
};

}  // namespace kagero
