#include "appearance/texture.h"

#include "geometry/shapes.h"
#include "scene/vector3.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <numbers>

namespace kagero {

namespace {

/// As std::floor, which without SSE4.1 is a call.
double floor_of(double x) {
    if (!(std::abs(x) < 4503599627370496.0)) return x;  // 2^52: all are whole
    const auto whole = static_cast<double>(static_cast<std::int64_t>(x));
    return whole > x ? whole - 1 : whole;
}

int wrapped(double index, int size, BeyondEdge edge) {
    if (!std::isfinite(index)) return 0;
    if (edge == BeyondEdge::clamp) return static_cast<int>(std::clamp(index, 0.0, size - 1.0));
    const double rest = index - floor_of(index / size) * size;
    return static_cast<int>(std::clamp(rest, 0.0, size - 1.0));
}

/// The two texels of a row or column around a place, and how far it is on the way from the first to the second.
struct Neighbours {
    int first, second;
    float share;

    Neighbours(double place, int size, BeyondEdge edge) {
        if (place >= 0 && place < size - 1)
            first = static_cast<int>(place), second = first + 1, share = static_cast<float>(place - first);
        else
            wrap(place, size, edge);
    }

private:
    /// Of a place that is not between two texels of the image: few are.
    [[gnu::noinline]] void wrap(double place, int size, BeyondEdge edge) {
        const double below = floor_of(place);
        first = wrapped(below, size, edge), second = wrapped(below + 1, size, edge),
        share = static_cast<float>(place - below);
    }
};

/// The square that a place is in: whether all within reach of the place is in it, and whether the sum of its numbers is
/// odd. Both axes side by side.
struct Square {
    bool alone, odd = false;

    Square(const std::array<double, 2>& place, const std::array<double, 2>& reach) {
        // Rounds to a whole number, which the sum's last bits hold. A place on an edge is in no square alone.
        constexpr double to_whole = 0x1.8p52;
        std::array<double, 2> sum, from_edge, most;
        for (std::size_t k = 0; k < 2; ++k) sum[k] = place[k] - 0.5 + to_whole;
        for (std::size_t k = 0; k < 2; ++k) from_edge[k] = place[k] - (sum[k] - to_whole), most[k] = 1 - reach[k];
        unsigned within = 1;  // as numbers, and not step by step: which it is no processor foresees
        for (std::size_t k = 0; k < 2; ++k) {
            within &= unsigned(std::abs(place[k]) < 0x1p51) & unsigned(from_edge[k] >= reach[k]) &
                      unsigned(from_edge[k] < most[k]);
            odd ^= std::bit_cast<std::uint64_t>(sum[k]) & 1;
        }
        alone = within;
    }
};

/// The squares along one axis of a checker, and what follows the last of them: the first (around), nothing (framed), or
/// more of them.
struct Row {
    enum class Beyond { first, nothing, more } beyond;
    double count;
};

/// The mean over an interval of the wave that is 1 from even numbers on and −1 from odd ones on. Its integral is the
/// distance to the nearest even number.
double mean_wave(double middle, double width, const Row& row) {
    const auto integral = [](double t) { return std::abs(t - 2 * floor_of(0.5 * t + 0.5)); };
    const auto over = [&](double from, double to) { return integral(to) - integral(from); };
    double lower = middle - 0.5 * width, upper = middle + 0.5 * width;
    if (row.beyond == Row::Beyond::nothing) lower = std::max(lower, 0.0), upper = std::min(upper, row.count);
    if (!(upper - lower >= 1e-6)) return 1 - 2 * (floor_of(middle) - 2 * floor_of(0.5 * floor_of(middle)));
    if (row.beyond == Row::Beyond::first) {
        if (width >= row.count) return over(0, row.count) / row.count;
        if (lower < 0) return (over(0, upper) + over(row.count + lower, row.count)) / width;
        if (upper > row.count) return (over(lower, row.count) + over(0, upper - row.count)) / width;
    }
    return over(lower, upper) / (upper - lower);
}

/// The mean over a parallelogram of a checker's sign, 1 and −1: over rectangles along the axes, the product of the
/// means of two waves; as many of them in a row along the longer axis, up to 64, as it takes to lie askew. Few places
/// need it.
[[gnu::noinline]] double mean_sign(double x, double y, const UvPatch& sides, const Row& columns, const Row& rows) {
    constexpr double most_pieces = 64;
    const PrincipalAxes axes = principal_axes(sides);
    const double askew = std::min(std::abs(axes.major[0]), std::abs(axes.major[1]));
    const double across = std::max(axes.across, askew / most_pieces);
    const double pieces = across > 0 ? std::clamp(std::ceil(askew / across - 1e-9), 1.0, most_pieces) : 1;
    const auto extent = [&](std::size_t axis) {
        const double of_piece = axes.major[axis] / pieces;
        return std::sqrt(of_piece * of_piece + axes.minor[axis] * axes.minor[axis]);
    };
    const double width = extent(0), height = extent(1);
    double sum = 0;
    for (double piece = 0.5; piece < pieces; ++piece) {
        const double t = piece / pieces - 0.5;
        sum += mean_wave(x + t * axes.major[0], width, columns) * mean_wave(y + t * axes.major[1], height, rows);
    }
    return sum / pieces;
}

}  // namespace

Float3 texture_color(const Image& image, double u, double v, Edges edges) {
    // Texel centres lie at half-integers; rows count from the top.
    const double x = u * image.width - 0.5, y = (1 - v) * image.height - 0.5;
    const Neighbours columns(x, image.width, edges.sides), rows(y, image.height, edges.ends);
    const float right = columns.share, down = rows.share;
    const auto row = [&](int i) {
        return image.rgb.data() + 3 * static_cast<std::size_t>(i) * static_cast<std::size_t>(image.width);
    };
    const float *upper = row(rows.first), *lower = row(rows.second);
    const std::ptrdiff_t left_at = 3 * columns.first, right_at = 3 * columns.second;
    const float lower_right = right * down, upper_right = right - lower_right, lower_left = down - lower_right,
                upper_left = 1 - right - lower_left;
    Float3 color;
    for (std::ptrdiff_t c = 0; c < 3; ++c)
        color[std::size_t(c)] = (upper_left * upper[left_at + c] + upper_right * upper[right_at + c]) +
                                (lower_left * lower[left_at + c] + lower_right * lower[right_at + c]);
    return color;
}

Float3 checker_color(const Paint& paint, double u, double v, const UvPatch& patch, Edges edges) {
    // From here on in squares.
    const std::array<double, 2> place{u * paint.checker[0], v * paint.checker[1]};
    std::array<double, 2> reach;
    for (std::size_t k = 0; k < 2; ++k)
        reach[k] = 0.5 * paint.checker[k] * (std::abs(patch.a[k]) + std::abs(patch.b[k]));
    const Square square(place, reach);
    double brightness;
    if (square.alone) {
        brightness = square.odd ? 0.25 : 1.0;
    } else {
        UvPatch sides;
        for (std::size_t k = 0; k < 2; ++k)
            sides.a[k] = patch.a[k] * paint.checker[k], sides.b[k] = patch.b[k] * paint.checker[k];
        // A mesh goes on with more squares where an image would begin again.
        const auto row = [&](BeyondEdge beyond, double count) {
            return Row{beyond == BeyondEdge::clamp        ? Row::Beyond::nothing
                       : edges.ends == BeyondEdge::repeat ? Row::Beyond::more
                                                          : Row::Beyond::first,
                       count};
        };
        brightness = 0.625 + 0.375 * mean_sign(place[0], place[1], sides, row(edges.sides, paint.checker[0]),
                                               row(edges.ends, paint.checker[1]));
    }
    Float3 color{};
    for (std::size_t c = 0; c < 3; ++c) color[c] = static_cast<float>(brightness * paint.color[c]);
    return color;
}

PrincipalAxes principal_axes(const UvPatch& patch) {
    const auto [ax, ay] = patch.a;
    const auto [bx, by] = patch.b;
    const double xx = ax * ax + bx * bx, xy = ax * ay + bx * by, yy = ay * ay + by * by;
    const double mean = 0.5 * (xx + yy), half = 0.5 * (xx - yy), difference = std::sqrt(half * half + xy * xy);
    const double along = std::sqrt(mean + difference), across = std::sqrt(std::max(0.0, mean - difference));
    // The major axis, at an angle the cosine of whose double is half / difference.
    const double twice = difference > 0 ? half / difference : 1;
    const double cosine = std::sqrt(std::max(0.0, 0.5 * (1 + twice))),
                 sine = std::copysign(std::sqrt(std::max(0.0, 0.5 * (1 - twice))), xy);
    return {{along * cosine, along * sine}, {-across * sine, across * cosine}, along, across};
}

std::array<double, 2> sky_coordinates(const Double3& direction, const SkyAxes& axes) {
    const double height = std::clamp(dot(direction, axes.up), -1.0, 1.0);
    const double longitude = std::atan2(dot(direction, axes.east), dot(direction, axes.zero));
    return {0.5 - longitude / (2 * std::numbers::pi), 0.5 + std::asin(height) / std::numbers::pi};
}

}  // namespace kagero
