/// Colours of images and checkers at points and over patches.
#pragma once

#include "film/image.h"
#include "appearance/chart.h"

namespace kagero {

/// Continuation of an image beyond its edges: repetitions of the image, or the texels at the edges.
enum class BeyondEdge { repeat, clamp };

/// Continuations of an image along u (to the left and right) and along v (above and below).
struct Edges {
    BeyondEdge along_u, along_v;
};
inline constexpr Edges repeat_both{BeyondEdge::repeat, BeyondEdge::repeat},
    repeat_along_u{BeyondEdge::repeat, BeyondEdge::clamp}, clamp_both{BeyondEdge::clamp, BeyondEdge::clamp};

/// Returns the colour of an image at (u, v), interpolated bilinearly. (0, 0) is the lower left corner of the image, and
/// (1, 1) is the upper right corner. `Stored` is the type of the image's components.
template <class Stored>
Float3 texture_color(const Texels<Stored>& texels, double u, double v, Edges edges);

/// Returns the mean colour of a checker over the patch around (u, v). `paint.checker` contains the numbers of squares
/// for u from 0 to 1 and for v from 0 to 1. The square at (0, 0) has the paint's colour, and its neighbours have a
/// quarter of it. If an axis is clamped, parts of the patch beyond the squares of that axis are ignored. The mean is
/// exact if the patch is a rectangle with sides parallel to u and v, or if it lies in one square.
Float3 checker_color(const Paint& paint, double u, double v, const UvPatch& patch = {}, Edges edges = repeat_both);

/// Symmetric 2 × 2 matrix a aᵀ + b bᵀ of a parallelogram with the sides a and b.
struct Covariance {
    double xx = 0, xy = 0, yy = 0;
};
/// Principal axes of a parallelogram: the sides of the rectangle that has the same covariance matrix.
struct PrincipalAxes {
    std::array<double, 2> major, minor;
    double major_length, minor_length;
};
/// Returns the principal axes of the parallelograms with a covariance matrix.
PrincipalAxes principal_axes(const Covariance& covariance);
/// Returns the principal axes of a patch.
PrincipalAxes principal_axes(const UvPatch& patch);

/// Returns u and v of a direction on an equirectangular sky. The pole is at the top, +x is in the middle, and east is
/// to the left.
std::array<double, 2> sky_coordinates(const Double3& direction, const SkyAxes& axes);

}  // namespace kagero
