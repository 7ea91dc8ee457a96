/// The colour of a surface at a point.
#pragma once

#include "appearance/pyramid.h"
#include "geometry/geometry.h"

namespace kagero {

/// A paint with its image.
struct LoadedPaint {
    Paint paint;
    std::shared_ptr<const Image> image;  ///< null unless a texture
    std::shared_ptr<const std::vector<Image>> coarser;  ///< copies of the image
};

/// What shading needs to know of an object, in coordinates relative to `space.center`.
struct ShadedObject {
    const ObjectGeometry* geometry = nullptr;
    Shading shading{};
    std::vector<LoadedPaint> paints;    ///< six of a box or room, else one
    std::vector<TriangleChart> charts;  ///< of the mesh, if a paint depends on the place on it
    Double3 normal{};                 ///< of a disk, as are those that follow
    double inner = 0, outer = 0;
    double temperature = 0, brightness = 0;  ///< brightness × luminance of a black body at that temperature = 1
};

/// Whether a paint looks different from place to place.
bool has_pattern(const LoadedPaint& paint);

/// Linear colour; `redshift` is g, the frequency seen over the frequency sent. Light that a disk sends with intensity
/// I(ν) is seen with g³ I(ν/g) (Liouville's theorem): a black body as one at g times its temperature, a colour g⁴ times
/// as bright. `point` relative to `space.center`, `toward` the unit direction of the ray. A pattern is averaged over
/// the patch. Head light: the colour times |normal · toward|.
Float3 object_color(const ShadedObject& object, std::uint32_t primitive, const Double3& point, const Double3& toward,
                    double redshift, const Patch& patch);

/// The sky in a unit direction; a pattern is averaged over the footprint.
Float3 sky_color(const LoadedPaint& paint, const SkyAxes& axes, const Double3& direction, const Footprint& footprint);

}  // namespace kagero
