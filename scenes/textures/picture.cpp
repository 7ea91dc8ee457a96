#include "picture.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <stdexcept>

namespace textures {

SkyPosition sky_position_of(const Picture& sky, int x, int y) {
    return {(0.5 - (x + 0.5) / sky.width) * 360 * degree, (0.5 - (y + 0.5) / sky.height) * 180 * degree};
}

Vec direction_of(const SkyPosition& position) {
    const double across = std::cos(position.latitude);
    return {across * std::cos(position.longitude), across * std::sin(position.longitude), std::sin(position.latitude)};
}

SkyPosition sky_position_of(const Vec& direction) {
    return {std::atan2(direction.y, direction.x), std::asin(direction.z / std::sqrt(dot(direction, direction)))};
}

Color dust_transmittance(double depth) {
    return {std::exp(-depth), std::exp(-1.45 * depth), std::exp(-2.1 * depth)};
}

void add_spot(Picture& sky, const SkyPosition& position, double width, const Color& peak) {
    const Vec middle = direction_of(position);
    // Contributions below 0.001 are not visible and are omitted.
    const double strength = std::max({peak.r, peak.g, peak.b});
    const double radius = width * std::sqrt(std::max(0.0, std::sqrt(strength / 0.001) - 1));
    const double row_height = 180 * degree / sky.height, column_width = 360 * degree / sky.width;
    const int middle_row = static_cast<int>((90 * degree - position.latitude) / row_height);
    const int middle_column = static_cast<int>((180 * degree - position.longitude) / column_width);
    const int rows = static_cast<int>(radius / row_height) + 1;
    for (int y = std::max(0, middle_row - rows); y <= std::min(sky.height - 1, middle_row + rows); ++y) {
        const double shrink = std::max(std::cos(sky_position_of(sky, 0, y).latitude), 1e-3);
        const int columns = std::min(sky.width / 2 - 1, static_cast<int>(radius / (shrink * column_width)) + 1);
        for (int x = middle_column - columns; x <= middle_column + columns; ++x) {
            const int column = ((x % sky.width) + sky.width) % sky.width;
            const double squared = 2 - 2 * dot(middle, direction_of(sky_position_of(sky, column, y)));
            const double falloff = 1 / (1 + squared / (width * width));
            Color& pixel = sky.at(column, y);
            pixel = pixel + falloff * falloff * peak;
        }
    }
}

Color star_color(double kelvin) {
    static constexpr struct {
        double kelvin;
        Color color;
    } table[] = {{2500, {1.00, 0.36, 0.10}},  {3500, {1.00, 0.56, 0.26}}, {4500, {1.00, 0.74, 0.48}},
                 {5800, {1.00, 0.93, 0.84}},  {7500, {0.86, 0.90, 1.00}}, {10000, {0.66, 0.78, 1.00}},
                 {20000, {0.48, 0.64, 1.00}}, {40000, {0.40, 0.57, 1.00}}};
    const auto* upper =
        std::find_if(std::begin(table) + 1, std::end(table) - 1, [=](const auto& row) { return row.kelvin > kelvin; });
    const auto* lower = upper - 1;
    return mix(lower->color, upper->color,
               std::clamp((kelvin - lower->kelvin) / (upper->kelvin - lower->kelvin), 0.0, 1.0));
}

void add_star(Picture& sky, Random& random, const SkyPosition& position, double faintest, double slope) {
    const double flux = std::min(faintest * std::pow(1 - random(), -1 / slope), 40.0);
    const double kelvin = 3200 * std::pow(1 - 0.9 * random(), -0.75);
    add_spot(sky, position, 0.11 * degree, flux * star_color(kelvin));
}

void tone_map(Picture& picture) {
    for (Color& c : picture.pixels) {
        // A part of the light above 1 in the brightest channel is added to all channels.
        const double excess = 0.12 * std::max(0.0, std::max({c.r, c.g, c.b}) - 1);
        c = {1 - std::exp(-c.r - excess), 1 - std::exp(-c.g - excess), 1 - std::exp(-c.b - excess)};
    }
}

namespace {

/// Returns the 8-bit sRGB value of a linear component.
unsigned char encode_srgb(double linear) {
    const double x = std::clamp(linear, 0.0, 1.0);
    return static_cast<unsigned char>(
        std::lround(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055)));
}

}  // namespace

void write_jpeg(Picture& picture, const std::string& path, int quality) {
    std::vector<unsigned char> bytes;
    bytes.reserve(3 * picture.pixels.size());
    for (const Color& c : picture.pixels)
        for (const double channel : {c.r, c.g, c.b}) bytes.push_back(encode_srgb(channel));
    OIIO::ImageSpec spec(picture.width, picture.height, 3, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("CompressionQuality", quality);
    const auto out = OIIO::ImageOutput::create(path);
    if (!out || !out->open(path, spec) || !out->write_image(OIIO::TypeDesc::UINT8, bytes.data()) || !out->close())
        throw std::runtime_error("cannot write '" + path + "': " + (out ? out->geterror() : OIIO::geterror()));
}

}  // namespace textures
