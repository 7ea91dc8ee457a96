#include "scene/texture.h"

#include "scene/shapes.h"
#include "scene/vector3.h"

#include <algorithm>
#include <numbers>

namespace kagero {

namespace {

int wrapped(double index, int size, Edge edge) {
    if (edge == Edge::clamp) return static_cast<int>(std::clamp(index, 0.0, size - 1.0));
    const double rest = index - std::floor(index / size) * size;
    return std::clamp(static_cast<int>(rest), 0, size - 1);
}

}  // namespace

Float3 texture_color(const Image& image, double u, double v, Edge vertical) {
    // Texel centres lie at half-integers; rows count from the top.
    const double x = u * image.width - 0.5, y = (1 - v) * image.height - 0.5;
    const double column = std::floor(x), row = std::floor(y);
    const double right = x - column, down = y - row;
    Float3 color{};
    for (int dy = 0; dy < 2; ++dy) {
        for (int dx = 0; dx < 2; ++dx) {
            const double weight = (dx ? right : 1 - right) * (dy ? down : 1 - down);
            const auto at_row = static_cast<std::size_t>(wrapped(row + dy, image.height, vertical));
            const auto at_column = static_cast<std::size_t>(wrapped(column + dx, image.width, Edge::repeat));
            const float* texel = &image.rgb[3 * (at_row * static_cast<std::size_t>(image.width) + at_column)];
            for (std::size_t c = 0; c < 3; ++c) color[c] += static_cast<float>(weight) * texel[c];
        }
    }
    return color;
}

Float3 checker_color(const Paint& paint, double u, double v) {
    const double square = std::floor(u * paint.checker[0]) + std::floor(v * paint.checker[1]);
    const bool odd = square - 2 * std::floor(square / 2) != 0;
    const double brightness = odd ? 0.25 : 1.0;
    Float3 color{};
    for (std::size_t c = 0; c < 3; ++c) color[c] = static_cast<float>(brightness * paint.color[c]);
    return color;
}

std::array<double, 2> sky_coordinates(const Double3& direction, const Double3& pole) {
    const Double3 up = unit(pole);
    const auto [zero, east] = meridians(up);  // the zero meridian runs through +x
    const double height = std::clamp(dot(direction, up), -1.0, 1.0);
    const double longitude = std::atan2(dot(direction, east), dot(direction, zero));
    return {0.5 - longitude / (2 * std::numbers::pi), 0.5 + std::asin(height) / std::numbers::pi};
}

}  // namespace kagero
