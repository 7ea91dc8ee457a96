/// Colours of images and checkers at points and over patches.
#pragma once

#include "film/image.h"
#include "appearance/chart.h"

namespace kagero {

/// Continuations of an image along u (to the left and right) and along v (above and below).
struct Edges {
    BeyondEdge along_u, along_v;
};
inline constexpr Edges repeat_both{BeyondEdge::repeat, BeyondEdge::repeat},
    repeat_along_u{BeyondEdge::repeat, BeyondEdge::clamp}, clamp_both{BeyondEdge::clamp, BeyondEdge::clamp};

/// Indices of the two texels next to a position in a row or column, for linear interpolation.
struct Neighbours {
    int first, second;
    float weight;  ///< Weight of the second texel.

    Neighbours(double position, int size, BeyondEdge edge) {
        if (position >= 0 && position < size - 1) {
            first = static_cast<int>(position);
            second = first + 1;
            weight = static_cast<float>(position - first);
        } else set_beyond_edge(position, size, edge);
    }

private:
    /// Sets the members for a position that is not between two texels of the image, which is rare.
    [[gnu::noinline]] void set_beyond_edge(double position, int size, BeyondEdge edge);
};

/// Returns the colour of an image at (u, v), interpolated bilinearly. (0, 0) is the lower left corner of the image, and
/// (1, 1) is the upper right corner. `Stored` is the type of the image's components. Inlined, because it is called
/// several times per pixel.
template <class Stored>
[[gnu::always_inline]] inline Float3 texture_color(const Texels<Stored>& texels, double u, double v, Edges edges) {
    // Texel centres are at half-integers, and rows are counted from the top.
    const double x = u * texels.width - 0.5, y = (1 - v) * texels.height - 0.5;
    const Neighbours columns(x, texels.width, edges.along_u), rows(y, texels.height, edges.along_v);
    const float right = columns.weight, down = rows.weight;
    const auto index = [&](int row, int column) {
        return 3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(texels.width) +
                    static_cast<std::size_t>(column));
    };
    const std::size_t upper_left_at = index(rows.first, columns.first),
                      upper_right_at = index(rows.first, columns.second),
                      lower_left_at = index(rows.second, columns.first),
                      lower_right_at = index(rows.second, columns.second);
    const float lower_right = right * down, upper_right = right - lower_right, lower_left = down - lower_right,
                upper_left = 1 - right - lower_left;
    Float3 color;
    for (std::size_t c = 0; c < 3; ++c)
        color[c] = (upper_left * texels[upper_left_at + c] + upper_right * texels[upper_right_at + c]) +
                   (lower_left * texels[lower_left_at + c] + lower_right * texels[lower_right_at + c]);
    return color;
}

/// Loads the texels around (u, v) into the cache if they are not at the edges of the image.
template <class Stored>
inline void prefetch_texels(const Texels<Stored>& texels, double u, double v) {
    const double x = u * texels.width - 0.5, y = (1 - v) * texels.height - 0.5;
    if (!(x >= 0 && x < texels.width && y >= 0 && y < texels.height - 1)) return;
    const auto width = static_cast<std::size_t>(texels.width);
    const Stored* const texel = texels.stored + 3 * (static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x));
    __builtin_prefetch(texel);
    __builtin_prefetch(texel + 3 * width);
}

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
