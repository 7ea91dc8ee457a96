/// Pictures of linear light, and light put into skies.
#pragma once

#include "noise.h"

#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

namespace textures {

constexpr double degree = std::numbers::pi / 180;

struct Color {
    double r = 0, g = 0, b = 0;
};

inline Color operator*(double s, const Color& c) {
    return {s * c.r, s * c.g, s * c.b};
}
inline Color operator*(const Color& a, const Color& b) {
    return {a.r * b.r, a.g * b.g, a.b * b.b};
}
inline Color operator+(const Color& a, const Color& b) {
    return {a.r + b.r, a.g + b.g, a.b + b.b};
}
inline Color mixed(const Color& a, const Color& b, double t) {
    return (1 - t) * a + t * b;
}

/// Rows from the top.
struct Picture {
    int width, height;
    std::vector<Color> pixels;

    Picture(int w, int h) : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
    Color& at(int x, int y) {
        return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    }
};

/// Longitude and latitude in radians; kagero's skies have +x in the middle and east, +y, to the left.
struct Place {
    double longitude, latitude;
};

Place place_of(const Picture& sky, int x, int y);
Vec direction_of(const Place& place);
Place place_of(const Vec& direction);

/// What is left of light after dust of the given depth: blue goes first.
Color through_dust(double depth);

/// Adds a spot of light to an equirectangular sky: `peak` in its middle, falling to a quarter at `width` (radians) from
/// there (Moffat 1969, beta = 2). Bright spots look larger, as on photographs.
void add_spot(Picture& sky, const Place& place, double width, const Color& peak);

/// Colour of a black body at `kelvin`, its greatest part 1, somewhat more vivid than the eye sees it.
Color star_color(double kelvin);

/// One star, its brightness from N(> F) ∝ F^(−slope): many faint, few bright.
void add_star(Picture& sky, Random& random, const Place& place, double faintest, double slope);

/// Film: any light becomes a value below 1, colours of bright light go towards white.
void develop(Picture& picture);

/// As JPEG, sRGB-encoded. Throws std::runtime_error.
void write_jpeg(Picture& picture, const std::string& path, int quality);

}  // namespace textures
