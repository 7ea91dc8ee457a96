/// One ray of a pixel, from the camera to its end, and what is known of it when its pixel is made.
#pragma once

#include "appearance/patch.h"
#include "appearance/sky_view.h"

namespace kagero {

/// The start of a camera's ray, and the frequency of its light for the camera's observer: p · u for the momentum of
/// `start`.
struct CameraRay {
    RayStart start;
    double frequency;
};

/// How wrong the end of a ray may be, in pixels of the film; not a number where that is not known.
struct EndError {
    double position = 0;  ///< of method, step and precision
    double rounding = 0;  ///< the most that precision alone can have done
};

/// Positions are relative to `space.center`.
struct PixelSample {
    const RayEnd* end = nullptr;
    const CameraRay* ray = nullptr;   ///< only where a layer or an object needs it
    const EndError* error = nullptr;  ///< only where a layer needs it
    Patch patch{};                    ///< of the surface that it meets
    SkyView sky{};                    ///< of a ray that escapes
};

}  // namespace kagero
