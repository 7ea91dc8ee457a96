/// Averages of an equirectangular image over pieces of the sphere.
#pragma once

#include "film/image.h"
#include "scene/geometry.h"

namespace kagero {

/// Ever coarser copies of an image, each with half the rows and columns of the one before; the last has one texel, the mean over
/// the sphere. Texels are averaged by solid angle.
std::vector<Image> coarser_images(const Image& image);

/// The image around a direction, averaged over the footprint: trilinear between the copies that resolve its short side, and by up
/// to 16 such probes along its long side (L. Williams, SIGGRAPH 1983; M. Kilgard's anisotropic filtering). A footprint smaller
/// than a texel gives the image itself, bilinearly.
Float3 sky_texture_color(const Image& image, const std::vector<Image>& coarser, const Double3& direction, const Double3& pole,
                         const Footprint& footprint);

}  // namespace kagero
