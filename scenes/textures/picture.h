/// Pictures with linear colours, and functions that add stars and galaxies to sky textures.
#pragma once

#include "noise.h"

#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

namespace textures {

/// One degree in radians.
constexpr double degree = std::numbers::pi / 180;

/// A linear RGB colour.
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
/// Interpolates linearly from a (t = 0) to b (t = 1).
inline Color mix(const Color& a, const Color& b, double t) {
    return (1 - t) * a + t * b;
}

/// A picture of linear colours, row by row from the top.
struct Picture {
    int width, height;
    std::vector<Color> pixels;

    Picture(int w, int h) : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
    Color& at(int x, int y) {
        return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    }
};

/// A direction as longitude and latitude in radians. In the sky textures of kagero, +x is in the middle and east (+y)
/// is to the left.
struct SkyPosition {
    double longitude, latitude;
};

/// Returns the direction at the centre of a pixel of an equirectangular sky.
SkyPosition sky_position_of(const Picture& sky, int x, int y);
/// Returns the unit vector of a direction.
Vec direction_of(const SkyPosition& position);
/// Returns longitude and latitude of a vector of any length.
SkyPosition sky_position_of(const Vec& direction);

/// Returns the fraction of light that passes dust of the given optical depth in red. Blue is absorbed most.
Color dust_transmittance(double depth);

/// Adds a spot of light to an equirectangular sky. The colour is `peak` at the centre and a quarter of it at the
/// distance `width` (radians): the profile of Moffat (1969) with beta = 2. Bright spots look larger, as in photographs.
void add_spot(Picture& sky, const SkyPosition& position, double width, const Color& peak);

/// Returns the colour of a black body at `kelvin`, scaled so that its greatest component is 1. The saturation is higher
/// than that of the real colour.
Color star_color(double kelvin);

/// Adds a star of random temperature. Its flux is at least `faintest` and follows N(> F) ∝ F^(−slope), so faint stars
/// are the most frequent.
void add_star(Picture& sky, Random& random, const SkyPosition& position, double faintest, double slope);

/// Maps all colours to the range 0 to 1. Bright colours approach white, as on photographic film.
void tone_map(Picture& picture);

/// Writes the picture as a JPEG file with sRGB encoding. Throws std::runtime_error if that fails.
void write_jpeg(Picture& picture, const std::string& path, int quality);

}  // namespace textures
