/// Mean colours of images over the footprints and patches of rays, from copies of decreasing resolution (mipmaps).
#pragma once

#include "film/image.h"
#include "appearance/texture.h"

namespace kagero {

/// Mapping of an image to a plane, or to a sphere by equirectangular projection.
enum class Mapping { plane, sphere };

/// Returns copies of an image with decreasing resolution. Each copy has half the rows and columns of the previous one,
/// rounded down. The last copy has one texel, the mean over the plane or sphere. Texels are weighted by their areas on
/// the plane or sphere.
std::vector<Image> coarser_images(const Image& image, Mapping mapping = Mapping::sphere);

/// The copies of an image and the number of points in which it is probed, for its mean over a stripe.
struct Probes {
    /// Copy whose texels are as large as the stripe is wide, as a real number: 0 is the image, and i is coarser[i − 1].
    double level = 0;
    int count = 1;  ///< Number of probes along the stripe, 1 to 16.

    Probes() = default;
    /// Computes both from the length and the width of a stripe, in texels. The width is increased to at least one texel
    /// and at least 1/16 of the length.
    Probes(double length, double width);
};

/// A footprint around a direction, and the probes in the image of the sky. Without an image, there is one probe.
struct SkyFilter {
    Footprint footprint{};
    Probes probes{};
};
/// Returns the filter with which an image is averaged over a footprint.
SkyFilter sky_filter(const Image& image, const Footprint& footprint);

/// Returns the image's mean colour over a footprint around a direction: the mean of the probes along the footprint's
/// long axis. A probe interpolates trilinearly between the two copies whose texels are closest in size to the short
/// axis (L. Williams, SIGGRAPH 1983). If the footprint is smaller than a texel, the result is the bilinear
/// interpolation of the image.
Float3 sky_texture_color(const Image& image, const std::vector<Image>& coarser, const Double3& direction,
                         const SkyAxes& axes, const SkyFilter& filter);

/// Returns the image's mean colour over a patch around a point on a sphere, computed as in sky_texture_color.
/// `from_center` is the point relative to the centre, and `right` and `below` are the sides of the patch.
Float3 sphere_texture_color(const Image& image, const std::vector<Image>& coarser, const Double3& from_center,
                            const Double3& right, const Double3& below);

/// Returns the image's mean colour over a patch around the point (u, v) of a surface, computed as in sky_texture_color.
Float3 surface_texture_color(const Image& image, const std::vector<Image>& coarser, double u, double v,
                             const UvPatch& patch, Edges edges);

}  // namespace kagero
