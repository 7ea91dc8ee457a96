/// Averages of images over what rays stand for.
#pragma once

#include "film/image.h"
#include "appearance/texture.h"

namespace kagero {

/// An image lies on a plane, or, equirectangular, on a sphere.
enum class Mapping { plane, sphere };

/// Ever coarser copies of an image, each with half the rows and columns of the one before; the last has one texel, the
/// mean over the plane or sphere. Texels are averaged by their areas there.
std::vector<Image> coarser_images(const Image& image, Mapping mapping = Mapping::sphere);

/// The image around a direction, averaged over the footprint: trilinear between the copies that resolve its short side,
/// and by up to 16 such probes along its long side (L. Williams, SIGGRAPH 1983; M. Kilgard's anisotropic filtering). A
/// footprint smaller than a texel gives the image itself, bilinearly.
Float3 sky_texture_color(const Image& image, const std::vector<Image>& coarser, const Double3& direction,
                         const SkyAxes& axes, const Footprint& footprint);

/// The same around a place on a sphere, relative to its centre, over a patch of it.
Float3 sphere_texture_color(const Image& image, const std::vector<Image>& coarser, const Double3& from_center,
                            const Double3& right, const Double3& below);

/// How many probes the first takes.
int sky_probes(const Image& image, const Footprint& footprint);

/// The same around a place on a surface, over the patch of u and v.
Float3 surface_texture_color(const Image& image, const std::vector<Image>& coarser, double u, double v,
                             const UvPatch& patch, Edges edges);

}  // namespace kagero
