/// Errors of ray ends as displacements on the picture.
#pragma once

#include "scene/vector3.h"

namespace kagero {

/// The linear map from displacements on the picture, in pixels, to displacements of a ray's end: those for one pixel to
/// the right and for one pixel down.
struct EndDerivatives {
    Double3 right, down;
};

/// Returns an error of a ray end, in pixels. Where one pixel of the picture covers more than `pixel_size`, the size of
/// a pixel of straight rays, the error is the displacement on the picture that changes the end by `error`. In the other
/// directions, it is the error divided by `pixel_size`, because the derivatives can vanish there. No displacement would
/// then cause the error.
double displacement_in_pixels(const EndDerivatives& derivatives, const Double3& error, double pixel_size);

}  // namespace kagero
