#include "appearance/texture.h"

#include "geometry/shapes.h"
#include "scene/vector3.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <numbers>

namespace kagero {

namespace {

/// Returns std::floor(x). Without SSE4.1, std::floor itself is compiled to a function call, which is slower.
double floor_of(double x) {
    if (!(std::abs(x) < 4503599627370496.0)) return x;  // 2^52: all greater numbers are integers
    const auto integer = static_cast<double>(static_cast<std::int64_t>(x));
    return integer > x ? integer - 1 : integer;
}

/// Returns the index of the texel at the whole-numbered position `index` of a row or column, which may be beyond the
/// edges of the image. Returns 0 if `index` is not finite.
int texel_index(double index, int size, BeyondEdge edge) {
    if (!std::isfinite(index)) return 0;
    if (edge == BeyondEdge::clamp) return static_cast<int>(std::clamp(index, 0.0, size - 1.0));
    const double repetition = floor_of(index / size), within = index - repetition * size;
    const bool is_mirrored = edge == BeyondEdge::mirror && repetition != 2 * floor_of(0.5 * repetition);
    const double wrapped = is_mirrored ? size - 1 - within : within;
    return static_cast<int>(std::clamp(wrapped, 0.0, size - 1.0));
}

/// The square of a checker that contains a position, in coordinates in which squares have edges of length 1. All loops
/// run over both axes, so that the compiler can vectorize them.
struct Square {
    bool contains_patch;  ///< True if all points within `reach` of the position along each axis lie in the square.
    bool is_odd = false;  ///< True if the sum of the square's indices is odd.

    Square(const std::array<double, 2>& position, const std::array<double, 2>& reach) {
        // Adding 1.5·2^52 rounds a number to an integer, which is in the low bits of the sum. A patch that touches the
        // upper edge of a square does not count as contained.
        constexpr double rounding_constant = 0x1.8p52;
        std::array<double, 2> sum, from_edge, limit;
        for (std::size_t k = 0; k < 2; ++k) sum[k] = position[k] - 0.5 + rounding_constant;
        for (std::size_t k = 0; k < 2; ++k) {
            from_edge[k] = position[k] - (sum[k] - rounding_constant);  // distance from the lower edge of the square
            limit[k] = 1 - reach[k];
        }
        unsigned within = 1;  // bit operations avoid branches, which would be unpredictable
        for (std::size_t k = 0; k < 2; ++k) {
            within &= unsigned(std::abs(position[k]) < 0x1p51) & unsigned(from_edge[k] >= reach[k]) &
                      unsigned(from_edge[k] < limit[k]);
            is_odd ^= std::bit_cast<std::uint64_t>(sum[k]) & 1;
        }
        contains_patch = within;
    }
};

/// Number of squares along one axis of a checker, and the continuation beyond the last square. The checker starts again
/// with its first square (`wrap`, around a sphere or disk), ends (`end`, on a rectangle or face), or continues with
/// further squares (`extend`, on a mesh).
struct CheckerAxis {
    enum class Beyond { wrap, end, extend } beyond;
    double count;
};

/// Returns the mean, over an interval, of the square wave that is 1 between an even number and the next integer, and −1
/// elsewhere. The integral of the wave is the distance to the nearest even number.
double mean_wave(double middle, double width, const CheckerAxis& axis) {
    const auto integral = [](double t) { return std::abs(t - 2 * floor_of(0.5 * t + 0.5)); };
    const auto integral_over = [&](double from, double to) { return integral(to) - integral(from); };
    double lower = middle - 0.5 * width, upper = middle + 0.5 * width;
    if (axis.beyond == CheckerAxis::Beyond::end) {
        lower = std::max(lower, 0.0);
        upper = std::min(upper, axis.count);
    }
    // For a short interval, the difference of integrals is inaccurate; the value at the middle is returned instead.
    if (!(upper - lower >= 1e-6)) return 1 - 2 * (floor_of(middle) - 2 * floor_of(0.5 * floor_of(middle)));
    if (axis.beyond == CheckerAxis::Beyond::wrap) {
        if (width >= axis.count) return integral_over(0, axis.count) / axis.count;
        if (lower < 0) return (integral_over(0, upper) + integral_over(axis.count + lower, axis.count)) / width;
        if (upper > axis.count)
            return (integral_over(lower, axis.count) + integral_over(0, upper - axis.count)) / width;
    }
    return integral_over(lower, upper) / (upper - lower);
}

/// Returns the mean over a parallelogram of the sign of a checker, which is 1 or −1 in alternating squares. For a
/// rectangle parallel to the axes, this is the product of the means of two square waves. An oblique parallelogram is
/// approximated by a row of up to 64 such rectangles along its longer axis. Not inlined, because it is rarely called.
[[gnu::noinline]] double mean_sign(double x, double y, const UvPatch& sides, const CheckerAxis& columns,
                                   const CheckerAxis& rows) {
    constexpr double max_rectangles = 64;
    const PrincipalAxes axes = principal_axes(sides);
    // The major axis is divided into parts whose smaller component is at most as long as the minor axis, if 64 parts
    // suffice. One part suffices if the major axis is parallel to u or v.
    const double smaller = std::min(std::abs(axes.major[0]), std::abs(axes.major[1]));
    const double max_part = std::max(axes.minor_length, smaller / max_rectangles);
    const double rectangles = max_part > 0 ? std::clamp(std::ceil(smaller / max_part - 1e-9), 1.0, max_rectangles) : 1;
    const auto extent = [&](std::size_t axis) {
        const double major_part = axes.major[axis] / rectangles;
        return std::sqrt(major_part * major_part + axes.minor[axis] * axes.minor[axis]);
    };
    const double width = extent(0), height = extent(1);
    double sum = 0;
    for (double i = 0.5; i < rectangles; ++i) {
        const double t = i / rectangles - 0.5;
        sum += mean_wave(x + t * axes.major[0], width, columns) * mean_wave(y + t * axes.major[1], height, rows);
    }
    return sum / rectangles;
}

}  // namespace

Float3 checker_color(const Paint& paint, double u, double v, const UvPatch& patch, Edges edges) {
    // All lengths from here on are in squares.
    const std::array<double, 2> position{u * paint.checker[0], v * paint.checker[1]};
    std::array<double, 2> reach;  // half the extents of the patch along u and v
    for (std::size_t k = 0; k < 2; ++k)
        reach[k] = 0.5 * paint.checker[k] * (std::abs(patch.a[k]) + std::abs(patch.b[k]));
    const Square square(position, reach);
    double brightness;
    if (square.contains_patch) {
        brightness = square.is_odd ? 0.25 : 1.0;
    } else {
        UvPatch sides;
        for (std::size_t k = 0; k < 2; ++k) {
            sides.a[k] = patch.a[k] * paint.checker[k];
            sides.b[k] = patch.b[k] * paint.checker[k];
        }
        // Only a mesh repeats images along v.
        const auto checker_axis = [&](BeyondEdge beyond, double count) {
            using Beyond = CheckerAxis::Beyond;
            const bool is_mesh = edges.along_v == BeyondEdge::repeat;
            return CheckerAxis{beyond == BeyondEdge::clamp ? Beyond::end : is_mesh ? Beyond::extend : Beyond::wrap,
                               count};
        };
        const CheckerAxis columns = checker_axis(edges.along_u, paint.checker[0]),
                          rows = checker_axis(edges.along_v, paint.checker[1]);
        brightness = 0.625 + 0.375 * mean_sign(position[0], position[1], sides, columns, rows);
    }
    Float3 color{};
    for (std::size_t c = 0; c < 3; ++c) color[c] = static_cast<float>(brightness * paint.color[c]);
    return color;
}

void Neighbours::set_beyond_edge(double position, int size, BeyondEdge edge) {
    const double below = floor_of(position);
    first = texel_index(below, size, edge);
    second = texel_index(below + 1, size, edge);
    weight = static_cast<float>(position - below);
}

PrincipalAxes principal_axes(const Covariance& covariance) {
    const auto [xx, xy, yy] = covariance;
    // The eigenvalues of the covariance matrix are mean ± difference.
    const double mean = 0.5 * (xx + yy), half = 0.5 * (xx - yy), difference = std::sqrt(half * half + xy * xy);
    const double major = std::sqrt(mean + difference), minor = std::sqrt(std::max(0.0, mean - difference));
    // The major axis is at the angle φ with cos 2φ = half / difference.
    const double cos_2phi = difference > 0 ? half / difference : 1;
    const double cosine = std::sqrt(std::max(0.0, 0.5 * (1 + cos_2phi))),
                 sine = std::copysign(std::sqrt(std::max(0.0, 0.5 * (1 - cos_2phi))), xy);
    return {{major * cosine, major * sine}, {-minor * sine, minor * cosine}, major, minor};
}

PrincipalAxes principal_axes(const UvPatch& patch) {
    const auto [ax, ay] = patch.a;
    const auto [bx, by] = patch.b;
    return principal_axes(Covariance{ax * ax + bx * bx, ax * ay + bx * by, ay * ay + by * by});
}

std::array<double, 2> sky_coordinates(const Double3& direction, const SkyAxes& axes) {
    const double height = std::clamp(dot(direction, axes.up), -1.0, 1.0);
    const double longitude = std::atan2(dot(direction, axes.east), dot(direction, axes.zero));
    return {0.5 - longitude / (2 * std::numbers::pi), 0.5 + std::asin(height) / std::numbers::pi};
}

}  // namespace kagero
