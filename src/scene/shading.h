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
    Double3 center{};                 ///< of a sphere
};

Float3 paint_color(const LoadedPaint& paint, double u, double v, Edge vertical = Edge::repeat);

/// Linear colour; `point` relative to `space.center`, `toward` the unit direction of the ray. A sphere's u is longitude (+x in
/// the middle, east to the right as seen from outside), its v latitude about z. Head light: the colour times |normal · toward|.
Float3 object_color(const ShadedObject& object, std::uint32_t primitive, const Double3& point, const Double3& toward);

}  // namespace kagero
