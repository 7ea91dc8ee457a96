#include "parts/tile_pixels.h"

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <vector>

namespace kagero {
namespace {

/// Returns those pixels of a tile that are in the film.
Tile pixels_in_film(const Tile& tile, const Film& film) {
    const CropWindow& window = film.window();
    return {std::max(tile.x0, window.x), std::max(tile.y0, window.y), std::min(tile.x1, window.x + film.width()),
            std::min(tile.y1, window.y + film.height())};
}

bool has_no_pixels(const Tile& pixels) { return pixels.x0 >= pixels.x1 || pixels.y0 >= pixels.y1; }

/// Calls visit(first float in the plane, number of pixels) for each row of pixels. `plane` is the first float of a
/// layer with this number of channels, or null; the first float is then null, too.
template <class Float, class Visit>
void for_each_pixel_row(const Tile& pixels, const Film& film, Float* plane, std::size_t channels, const Visit& visit) {
    constexpr std::size_t cache_line = 64 / sizeof(float);
    const CropWindow& window = film.window();
    const std::size_t row_length = film.width() * channels, used = (pixels.x1 - pixels.x0) * channels;
    for (std::uint32_t y = pixels.y0; y < pixels.y1; ++y) {
        Float* const row = plane ? plane + (y - window.y) * row_length + (pixels.x0 - window.x) * channels : nullptr;
        // Rows are far apart in memory, so that the processor does not load the next one by itself.
        for (std::size_t i = 0; plane && y + 1 < pixels.y1 && i < used; i += cache_line)
            __builtin_prefetch(row + row_length + i, !std::is_const_v<Float>);
        visit(row, pixels.x1 - pixels.x0);
    }
}

/// Returns true if all pixels of a row have the same bits.
bool is_uniform(const float* row, std::uint32_t count, std::size_t channels) {
    return std::memcmp(row, row + channels, (count - 1) * channels * sizeof(float)) == 0;
}

/// Writes the number of pixels that follow, and these pixels: all of the row, or one that all others equal.
void put_row(ByteWriter& writer, const float* row, std::uint32_t count, std::size_t channels) {
    const std::uint32_t written = is_uniform(row, count, channels) ? 1 : count;
    writer.put(written);
    writer.put_raw(row, written * channels * sizeof(float));
}

/// Reads a row of pixels that put_row has written.
void get_row(ByteReader& reader, float* row, std::uint32_t count, std::size_t channels) {
    const auto written = reader.get<std::uint32_t>();
    if (written != 1 && written != count) throw InputError("a record has another number of pixels than its tile");
    reader.get_raw(row, written * channels * sizeof(float));
    for (std::uint32_t i = written; i < count; ++i)  // copies also the bits of a NaN
        std::memcpy(row + i * channels, row, channels * sizeof(float));
}

}  // namespace

void put_pixels(ByteWriter& writer, const Tile& tile, const Film& film) {
    const Tile pixels = pixels_in_film(tile, film);
    if (has_no_pixels(pixels)) return;
    for (const LayerInfo* layer : film.layers()) {
        const std::size_t channels = layer->channels.size();
        for_each_pixel_row(pixels, film, film.plane(layer->name), channels,
                           [&](const float* row, std::uint32_t count) { put_row(writer, row, count, channels); });
    }
}

void get_pixels(ByteReader& reader, const Tile& tile, Film& film) {
    const Tile pixels = pixels_in_film(tile, film);
    if (has_no_pixels(pixels)) return;
    for (const LayerInfo* layer : film.layers()) {
        const std::size_t channels = layer->channels.size();
        std::vector<float> skipped(film.plane(layer->name) ? 0 : (pixels.x1 - pixels.x0) * channels);
        for_each_pixel_row(pixels, film, film.plane(layer->name), channels, [&](float* row, std::uint32_t count) {
            get_row(reader, row ? row : skipped.data(), count, channels);
        });
    }
}

}  // namespace kagero
