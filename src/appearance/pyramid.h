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

/// Returns the image's mean colour over a footprint around a direction. The mean is that of up to 16 probes along the
/// footprint's long axis. A probe interpolates trilinearly between the two copies whose texels are closest in size to
/// the short axis (L. Williams, SIGGRAPH 1983). If the footprint is smaller than a texel, the result is the bilinear
/// interpolation of the image.
Float3 sky_texture_color(const Image& image, const std::vector<Image>& coarser, const Double3& direction,
                         const SkyAxes& axes, const Footprint& footprint);

/// Returns the image's mean colour over a patch around a point on a sphere, computed as in sky_texture_color.
/// `from_center` is the point relative to the centre, and `right` and `below` are the sides of the patch.
Float3 sphere_texture_color(const Image& image, const std::vector<Image>& coarser, const Double3& from_center,
                            const Double3& right, const Double3& below);

/// Returns the number of probes in sky_texture_color for a footprint.
int sky_probes(const Image& image, const Footprint& footprint);

/// Returns the image's mean colour over a patch around the point (u, v) of a surface, computed as in sky_texture_color.
Float3 surface_texture_color(const Image& image, const std::vector<Image>& coarser, double u, double v,
                             const UvPatch& patch, Edges edges);

}  // namespace kagero
