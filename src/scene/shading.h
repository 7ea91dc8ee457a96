/// The colour of a surface at a point.
#pragma once

#include "scene/shapes.h"
#include "scene/texture.h"

namespace kagero {

/// A paint with its image.
struct LoadedPaint {
    Paint paint;
    std::shared_ptr<const Image> image;  ///< null unless a texture
};

/// What shading needs to know of an object, in coordinates relative to `space.center`.
struct ShadedObject {
    Shape shape{};
    Shading shading{};
    std::vector<LoadedPaint> paints;  ///< six of a box or room, else one
    TriangleMesh mesh;                ///< empty for a sphere
    Double3 center{};                 ///< of a sphere or disk
    Double3 normal{};                 ///< of a disk, as are those that follow
    double inner = 0, outer = 0;
    double temperature = 0, brightness = 0;  ///< brightness × luminance of a black body at that temperature = 1
};

Float3 paint_color(const LoadedPaint& paint, double u, double v, Edge vertical = Edge::repeat);

/// Linear colour; `redshift` is g, the frequency seen over the frequency sent. Light that a disk sends with intensity I(ν) is seen with
/// g³ I(ν/g) (Liouville's theorem): a black body as one at g times its temperature, a colour g⁴ times as bright. `point` relative to `space.center`, `toward` the unit direction of the ray. A sphere's u is longitude (+x in
/// the middle, east to the right as seen from outside), its v latitude about z. Head light: the colour times |normal · toward|.
Float3 object_color(const ShadedObject& object, std::uint32_t primitive, const Double3& point, const Double3& toward,
                    double redshift = 1);

}  // namespace kagero
