/// Looking up colours in images and checkers.
#pragma once

#include "film/image.h"
#include "appearance/chart.h"

namespace kagero {

/// What happens beyond an edge of an image.
enum class BeyondEdge { repeat, clamp };

/// … left and right of it, and above and below.
struct Edges {
    BeyondEdge sides, ends;
};
inline constexpr Edges tiled{BeyondEdge::repeat, BeyondEdge::repeat}, around{BeyondEdge::repeat, BeyondEdge::clamp},
    framed{BeyondEdge::clamp, BeyondEdge::clamp};

/// Bilinear: (0,0) is the lower left corner of the image, (1,1) the upper right.
Float3 texture_color(const Image& image, double u, double v, Edges edges);

/// `paint.checker` squares along u and v in 0…1; the square at (0,0) has the paint's colour, its neighbours a quarter
/// of it. The mean over the patch around (u, v), as far as there are squares: exact where its longer side lies along u
/// or v, or it touches one square alone.
Float3 checker_color(const Paint& paint, double u, double v, const UvPatch& patch = {}, Edges edges = tiled);

/// The principal axes of the ellipse that has the variances of a parallelogram; the axes' full lengths are those of the
/// sides of a rectangle with the same variances.
struct PrincipalAxes {
    std::array<double, 2> major, minor;
    double along, across;  ///< their lengths
};
PrincipalAxes principal_axes(const UvPatch& patch);

/// Image coordinates of a direction in an equirectangular sky: the pole is up, +x in the middle, east to the left.
std::array<double, 2> sky_coordinates(const Double3& direction, const SkyAxes& axes);

}  // namespace kagero
