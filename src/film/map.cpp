#include "film/map.h"

#include "error.h"
#include "film/codec.h"
#include "film/image.h"
#include "film/png.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

namespace kagero {
namespace {

// Sizes in pixels. The colour bar is `gap` pixels to the right of the film.
constexpr int gap = 8, bar_width = 14, glyph_width = 6, glyph_height = 7, label_width = 9 * glyph_width;

/// Characters of numbers, and their bitmaps: seven rows of five bits each; bit 4 is the leftmost column.
constexpr const char* glyph_characters = "0123456789.e-+";
constexpr unsigned char glyphs[][glyph_height] = {
    {14, 17, 19, 21, 25, 17, 14}, {4, 12, 4, 4, 4, 4, 14},     {14, 17, 1, 2, 4, 8, 31},     {31, 2, 4, 2, 1, 17, 14},
    {2, 6, 10, 18, 31, 2, 2},     {31, 16, 30, 1, 1, 17, 14},  {6, 8, 16, 30, 17, 17, 14},   {31, 1, 2, 4, 8, 8, 8},
    {14, 17, 17, 14, 17, 17, 14}, {14, 17, 17, 15, 1, 2, 12},  {0, 0, 0, 0, 0, 12, 12},      {0, 0, 14, 17, 31, 16, 14},
    {0, 0, 0, 31, 0, 0, 0},       {0, 4, 4, 31, 4, 4, 0}};

/// Maps values to positions on a scale in [0, 1] and back, linearly or logarithmically.
class ColorScale {
public:
    ColorScale(const float* values, std::size_t count, bool logarithmic) : logarithmic_(logarithmic) {
        for (std::size_t i = 0; i < count; ++i) {
            if (!std::isfinite(values[i])) continue;
            greatest_ = std::max(greatest_, double(values[i]));
            if (values[i] > 0) least_ = least_ > 0 ? std::min(least_, double(values[i])) : double(values[i]);
        }
        if (!logarithmic_) least_ = 0;
        if (!(greatest_ > least_)) greatest_ = least_ > 0 ? 2 * least_ : 1;
        if (logarithmic_ && !(least_ > 0)) least_ = 1e-3 * greatest_;
    }
    /// Returns true if `position` is defined for the value: it is finite, and positive if the scale is logarithmic.
    bool has_position(double value) const { return std::isfinite(value) && (!logarithmic_ || value > 0); }
    /// Returns the position of a value on the scale: in [0, 1], or less than 0 for a negative value on a linear scale.
    double position(double value) const {
        return logarithmic_ ? std::log(value / least_) / std::log(greatest_ / least_) : value / greatest_;
    }
    /// Returns the value at a position on the scale.
    double value(double position) const {
        return logarithmic_ ? least_ * std::pow(greatest_ / least_, position) : position * greatest_;
    }

private:
    bool logarithmic_;
    double least_ = 0, greatest_ = 0;
};

/// A white RGB picture with one byte per channel.
struct Canvas {
    int width, height;
    std::vector<unsigned char> rgb = std::vector<unsigned char>(std::size_t(3) * width * height, 255);

    unsigned char* pixel(int x, int y) { return &rgb[3 * (std::size_t(y) * width + x)]; }
};

/// Draws a number in black. Its upper left corner is at (x, y).
void draw_number(Canvas& canvas, int x, int y, double value) {
    char text[32];
    const char* const end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, 4).ptr;
    for (const char* c = text; c != end; ++c, x += glyph_width) {
        const char* const at = std::char_traits<char>::find(glyph_characters, std::size(glyphs), *c);
        if (!at) continue;
        for (int row = 0; row < glyph_height; ++row)
            for (int column = 0; column < 5 && x + column < canvas.width; ++column)
                if (glyphs[at - glyph_characters][row] >> (4 - column) & 1)
                    std::fill_n(canvas.pixel(x + column, y + row), 3, 0);
    }
}

/// Returns the positions on the scale of all pixels of the map, which has `width` columns: the pixels of the film, a
/// gap of zeros, and the colour bar. Pixels whose value is not on the scale have a negative position.
std::vector<float> scale_positions(const Film& film, const float* values, const ColorScale& scale, int width) {
    const int w = static_cast<int>(film.width()), h = static_cast<int>(film.height());
    std::vector<float> plane(std::size_t(width) * h, 0);
    for (int y = 0; y < h; ++y) {
        for (int x = 0; x < w; ++x) {
            const double value = values[std::size_t(y) * w + x];
            plane[std::size_t(y) * width + x] = scale.has_position(value) ? float(scale.position(value)) : -1.0f;
        }
        for (int x = w + gap; x < width; ++x)
            plane[std::size_t(y) * width + x] = h > 1 ? 1 - float(y) / float(h - 1) : 1;
    }
    return plane;
}

}  // namespace

std::string map_path(const std::string& picture, const LayerInfo& layer) {
    const std::filesystem::path path(picture);
    return (path.parent_path() / (path.stem().string() + "-" + layer.name + ".png")).string();
}

FalseColors false_colors_of(const float* numbers, std::size_t count, const LayerInfo& layer) {
    const ColorScale scale(numbers, count, layer.scale == LayerInfo::Scale::logarithmic);
    std::vector<float> positions(count);
    for (std::size_t i = 0; i < count; ++i)
        positions[i] = scale.has_position(numbers[i]) ? float(scale.position(numbers[i])) : -1.0f;
    return {false_colored(positions), scale.value(0), scale.value(1)};
}

void write_map(const Film& film, const LayerInfo& layer, const std::string& path) {
    const float* const values = film.plane(layer.name);
    const int w = static_cast<int>(film.width()), h = static_cast<int>(film.height()), map_width = w + gap + bar_width;
    const ColorScale scale(values, std::size_t(w) * h, layer.scale == LayerInfo::Scale::logarithmic);
    const std::vector<unsigned char> colored = false_colored(scale_positions(film, values, scale, map_width));

    Canvas canvas{map_width + gap / 2 + label_width, h};
    for (int y = 0; y < h; ++y) {
        const unsigned char* const row = &colored[std::size_t(3) * y * map_width];
        std::copy_n(row, 3 * w, canvas.pixel(0, y));
        std::copy_n(row + 3 * (w + gap), 3 * bar_width, canvas.pixel(w + gap, y));
    }
    const int labels = std::clamp(h / 24, 2, 5);
    for (int i = 0; i < labels && h >= glyph_height; ++i) {
        const double position = double(i) / (labels - 1);
        draw_number(canvas, map_width + gap / 2, static_cast<int>(std::lround((1 - position) * (h - glyph_height))),
                     scale.value(position));
    }
    write_picture(path, {canvas.width, h, 3, PictureToEncode::Samples::bytes, canvas.rgb.data()});
}

}  // namespace kagero
