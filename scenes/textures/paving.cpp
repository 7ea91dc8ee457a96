// Stone paving seen from above. The texture is periodic in both directions.
#include "textures.h"

#include <algorithm>
#include <limits>

namespace textures {

namespace {

constexpr std::uint64_t seed = 400;
constexpr int columns = 10, rows = 12;  // Stones per side; every second row is shifted by half a stone.
constexpr double jitter = 0.36;         // Range of the random displacement of a stone, in stones.
constexpr double joint = 0.045;         // Half the width of a mortar joint, in stones.

/// The stone at a point: its column and row, and the distance to its edge, in stones.
struct Stone {
    std::int64_t column, row;
    double edge;
};

struct Point {
    double x, y;
};

/// Returns the centre of a stone, in stones. Columns and rows repeat after one picture.
Point stone_center(std::int64_t column, std::int64_t row) {
    const std::int64_t c = ((column % columns) + columns) % columns, r = ((row % rows) + rows) % rows;
    return {static_cast<double>(column) + 0.5 + 0.5 * static_cast<double>(r % 2) +
                jitter * (lattice_random(seed, c, r, 1) - 0.5),
            static_cast<double>(row) + 0.5 + jitter * (lattice_random(seed, c, r, 2) - 0.5)};
}

/// Returns the distance in the L3 norm, which makes the cells of the stones roughly rectangular.
double distance(const Point& a, const Point& b) {
    const double dx = std::abs(a.x - b.x), dy = std::abs(a.y - b.y);
    return std::pow(dx * dx * dx + dy * dy * dy, 1.0 / 3);
}

/// Returns the stone whose centre is nearest. Half the difference of the distances to the two nearest centres estimates
/// the distance to its edge.
Stone stone_at(const Point& p) {
    Stone stone{0, 0, 0};
    double nearest = std::numeric_limits<double>::max(), second = nearest;
    const auto column = static_cast<std::int64_t>(std::floor(p.x)), row = static_cast<std::int64_t>(std::floor(p.y));
    for (std::int64_t r = row - 2; r <= row + 2; ++r)
        for (std::int64_t c = column - 2; c <= column + 2; ++c) {
            const double d = distance(p, stone_center(c, r));
            if (d < nearest) stone = {c, r, 0};
            second = d < nearest ? nearest : std::min(second, d);
            nearest = std::min(nearest, d);
        }
    stone.edge = 0.5 * (second - nearest);
    stone.column = ((stone.column % columns) + columns) % columns;
    stone.row = ((stone.row % rows) + rows) % rows;
    return stone;
}

/// The material and the height of the paving at a point.
struct SurfacePoint {
    Stone stone;
    double u, v;       // Position in the picture, 0 to 1.
    double stoneness;  // 0 in the mortar, 1 on the stone, between at the edge.
    double height;
};

/// Returns fractal noise that is periodic over the picture. `frequency` is the number of noise cells per side.
double periodic_noise(std::uint64_t which, double u, double v, std::int64_t frequency, int octaves, double gain = 0.5) {
    const auto f = static_cast<double>(frequency);
    return fractal_noise(seed + which, {f * u, f * v, 0.5}, octaves, gain, frequency);
}

SurfacePoint surface_at(double u, double v) {
    const double wobble_x = 0.10 * periodic_noise(10, u, v, 24, 3), wobble_y = 0.10 * periodic_noise(20, u, v, 24, 3);
    SurfacePoint g{stone_at({u * columns + wobble_x, v * rows + wobble_y}), u, v, 0, 0};
    g.stoneness = smoothstep(joint, joint + 0.035, g.stone.edge);
    const double rounded = std::sqrt(smoothstep(0.0, 0.30, g.stone.edge));
    const double tilt_u = lattice_random(seed, g.stone.column, g.stone.row, 3) - 0.5,
                 tilt_v = lattice_random(seed, g.stone.column, g.stone.row, 4) - 0.5;
    const double tilt =
        2.5 * (tilt_u * std::sin(2 * std::numbers::pi * u) + tilt_v * std::sin(2 * std::numbers::pi * v));
    g.height = g.stoneness * (0.55 + 0.40 * rounded + 0.05 * tilt) + 0.07 * periodic_noise(30, u, v, 40, 5, 0.62);
    return g;
}

Color stone_color(const SurfacePoint& g) {
    static constexpr Color kinds[] = {
        {0.42, 0.35, 0.27}, {0.34, 0.31, 0.28}, {0.27, 0.275, 0.28}, {0.38, 0.28, 0.22}, {0.46, 0.41, 0.34}};
    const auto kind = static_cast<std::size_t>(5 * lattice_random(seed, g.stone.column, g.stone.row, 5));
    const double tone = 0.78 + 0.44 * lattice_random(seed, g.stone.column, g.stone.row, 6);
    const double stains = 1 + 0.22 * periodic_noise(40, g.u, g.v, 16, 5, 0.6),
                 specks = 1 + 0.30 * periodic_noise(50, g.u, g.v, 128, 3, 0.8);
    return tone * stains * specks * kinds[kind];
}

Color mortar_color(const SurfacePoint& g) {
    const Color sand{0.20, 0.165, 0.12}, moss{0.085, 0.115, 0.035};
    return (1 + 0.4 * periodic_noise(60, g.u, g.v, 128, 3, 0.8)) *
           mix(sand, moss, smoothstep(-0.05, 0.35, periodic_noise(70, g.u, g.v, 6, 4)));
}

}  // namespace

Picture paving() {
    Picture picture(1024, 1024);
    std::vector<SurfacePoint> surface;
    surface.reserve(picture.pixels.size());
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x)
            surface.push_back(surface_at((x + 0.5) / picture.width, (y + 0.5) / picture.height));
    const auto height = [&](int x, int y) {
        return surface[static_cast<std::size_t>(((y + 1024) % 1024) * 1024 + (x + 1024) % 1024)].height;
    };
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x) {
            const SurfacePoint& g = surface[static_cast<std::size_t>(y * 1024 + x)];
            // Sunlight comes from the upper left at a low angle.
            const double slope = (height(x + 1, y) - height(x - 1, y)) + 0.7 * (height(x, y + 1) - height(x, y - 1));
            const double sun = std::clamp(1 + 1.5 * slope, 0.45, 1.6);
            picture.at(x, y) = sun * mix(mortar_color(g), stone_color(g), g.stoneness);
        }
    return picture;
}

}  // namespace textures
