#include "parts/tile_pixels.h"

#include <algorithm>
#include <memory>

namespace kagero {
namespace {

/// Bits of a float.
using Bits = std::uint32_t;

/// Returns those pixels of a tile that are in the film.
Tile pixels_in_film(const Tile& tile, const Film& film) {
    const CropWindow& window = film.window();
    return {std::max(tile.x0, window.x), std::max(tile.y0, window.y), std::min(tile.x1, window.x + film.width()),
            std::min(tile.y1, window.y + film.height())};
}

bool has_no_pixels(const Tile& pixels) { return pixels.x0 >= pixels.x1 || pixels.y0 >= pixels.y1; }

/// Numbers of pixels in a section and after it.
struct SectionSize {
    std::uint32_t pixels, repetitions;
};

/// The floats of the pixels of a layer. They are not set at first.
struct FloatList {
    std::size_t size;
    std::unique_ptr<Bits[]> floats;

    FloatList(const Tile& pixels, std::size_t channels)
        : size(std::size_t{pixels.x1 - pixels.x0} * (pixels.y1 - pixels.y0) * channels),
          floats(std::make_unique_for_overwrite<Bits[]>(size)) {}
};

/// Calls visit(first float in the plane, position in the list of the tile's floats, number of floats) for each row of
/// pixels. `plane` is the first float of a layer with this number of channels.
template <class Float, class Visit>
void for_each_pixel_row(const Tile& pixels, const Film& film, Float* plane, std::size_t channels, const Visit& visit) {
    const std::size_t row = (pixels.x1 - pixels.x0) * channels;
    const CropWindow& window = film.window();
    for (std::uint32_t y = pixels.y0; y < pixels.y1; ++y) {
        const std::size_t first = std::size_t{y - window.y} * film.width() + (pixels.x0 - window.x);
        visit(plane + first * channels, (y - pixels.y0) * row, row);
    }
}

/// Finds repetitions in a list of pixels with a fixed number of channels.
template <std::size_t channels>
class RepetitionFinder {
public:
    RepetitionFinder(const Bits* pixels, std::size_t count) : pixels_(pixels), count_(count) {}

    /// Returns the first pixel from `begin` on that is repeated at least `fewest` times; the last one if there is none.
    std::size_t find(std::size_t begin) const {
        for (std::size_t i = begin; i + fewest < count_; ++i)
            if (equal(i, i + 1) && equal(i, i + 2)) return i;
        return count_ - 1;
    }
    /// Returns the number of pixels after pixel `i` that equal it: floats are compared with those of the next pixel,
    /// several at a time where these are equal.
    std::size_t repetitions(std::size_t i) const {
        const Bits* const floats = pixels_ + i * channels;
        const std::size_t compared = (count_ - 1 - i) * channels;
        std::size_t same = 0;
        while (same + block <= compared && difference<block>(floats + same, floats + same + channels) == 0)
            same += block;
        while (same < compared && floats[same] == floats[same + channels]) ++same;
        return same / channels;
    }

private:
    /// Fewest repetitions for which a section ends. A section has eight bytes in addition to its pixels.
    static constexpr std::size_t fewest = 2;

    /// Number of floats that are compared at a time. Compilers use registers of several floats for the loop.
    static constexpr std::size_t block = 16;

    /// Returns 0 if two sequences of floats are equal.
    template <std::size_t count>
    static Bits difference(const Bits* a, const Bits* b) {
        Bits bits = 0;
        for (std::size_t k = 0; k < count; ++k) bits |= a[k] ^ b[k];
        return bits;
    }
    bool equal(std::size_t i, std::size_t k) const {
        return difference<channels>(pixels_ + i * channels, pixels_ + k * channels) == 0;
    }

    const Bits* pixels_;
    std::size_t count_;
};

template <std::size_t channels>
void put_sections(ByteWriter& writer, const FloatList& list) {
    const std::size_t count = list.size / channels;
    const RepetitionFinder<channels> finder(list.floats.get(), count);
    // Each section but the last one has at least three pixels with its repetitions.
    const auto sections =
        std::make_unique_for_overwrite<char[]>(list.size * sizeof(Bits) + (count / 3 + 2) * sizeof(SectionSize));
    char* end = sections.get();
    const auto put = [&](const void* data, std::size_t size) {
        std::memcpy(end, data, size);
        end += size;
    };
    for (std::size_t begin = 0; begin < count;) {
        const std::size_t last = finder.find(begin), repetitions = finder.repetitions(last);
        const SectionSize size{static_cast<std::uint32_t>(last + 1 - begin), static_cast<std::uint32_t>(repetitions)};
        put(&size, sizeof size);
        put(&list.floats[begin * channels], size.pixels * channels * sizeof(Bits));
        begin = last + 1 + repetitions;
    }
    writer.put_raw(sections.get(), static_cast<std::size_t>(end - sections.get()));
}

/// Fills the list with the pixels of a layer, as put_sections<channels> has written them.
void get_sections(ByteReader& reader, std::size_t channels, FloatList& list) {
    const std::size_t count = list.size / channels;
    Bits* const floats = list.floats.get();
    for (std::size_t begin = 0; begin < count;) {
        const auto [pixels, repetitions] = reader.get<SectionSize>();
        if (pixels == 0 || pixels > count - begin || repetitions > count - begin - pixels)
            throw InputError("a record has another number of pixels than its tile");
        reader.get_raw(floats + begin * channels, pixels * channels * sizeof(Bits));
        begin += pixels;
        const std::size_t last = (begin - 1) * channels;
        for (std::size_t i = 0; i < repetitions * channels; ++i)
            floats[begin * channels + i] = floats[last + i % channels];
        begin += repetitions;
    }
}

}  // namespace

void put_pixels(ByteWriter& writer, const Tile& tile, const Film& film) {
    const Tile pixels = pixels_in_film(tile, film);
    if (has_no_pixels(pixels)) return;
    for (const LayerInfo* layer : film.layers()) {
        const std::size_t channels = layer->channels.size();
        FloatList list(pixels, channels);
        for_each_pixel_row(pixels, film, film.plane(layer->name), channels,
                           [&](const float* row, std::size_t position, std::size_t floats) {
                               std::memcpy(&list.floats[position], row, floats * sizeof(float));
                           });
        if (channels == 3) put_sections<3>(writer, list);
        else put_sections<1>(writer, list);
    }
}

void get_pixels(ByteReader& reader, const Tile& tile, Film& film) {
    const Tile pixels = pixels_in_film(tile, film);
    if (has_no_pixels(pixels)) return;
    for (const LayerInfo* layer : film.layers()) {
        const std::size_t channels = layer->channels.size();
        FloatList list(pixels, channels);
        get_sections(reader, channels == 3 ? 3 : 1, list);
        float* const plane = film.plane(layer->name);
        if (!plane) continue;
        for_each_pixel_row(pixels, film, plane, channels, [&](float* row, std::size_t position, std::size_t floats) {
            std::memcpy(row, &list.floats[position], floats * sizeof(float));
        });
    }
}

}  // namespace kagero
