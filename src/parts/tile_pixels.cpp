#include "parts/tile_pixels.h"

#include <emmintrin.h>

#include <algorithm>
#include <bit>
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

/// Numbers of pixels in a section and after it.
struct SectionSize {
    std::uint32_t pixels, repetitions;
};

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

/// Finds repetitions in a row of pixels with a fixed number of channels.
template <std::size_t channels>
class RepetitionFinder {
public:
    RepetitionFinder(const float* pixels, std::uint32_t count) : pixels_(pixels), count_(count) {}

    /// Returns the first pixel from `begin` on that is repeated at least `fewest` times; the last one if there is none.
    std::uint32_t find(std::uint32_t begin) const {
        for (std::uint32_t i = begin; i + fewest < count_;) {
            if (all_differ(i)) i += block / channels;
            else if (!equal(i + 1, i + 2)) i += 2;  // neither of both pixels is repeated as often
            else if (equal(i, i + 1)) return i;
            else ++i;
        }
        return count_ - 1;
    }
    /// Returns the number of pixels after pixel `i` that equal it: floats are compared with those of the next pixel.
    std::uint32_t repetitions(std::uint32_t i) const {
        const float* const floats = pixels_ + i * channels;
        const std::size_t compared = (count_ - 1 - i) * channels;
        std::size_t same = 0;
        while (same + block <= compared && all_are_equal(floats + same, floats + same + channels)) same += block;
        while (same < compared && has_same_bits(floats[same], floats[same + channels])) ++same;
        return static_cast<std::uint32_t>(same / channels);
    }

private:
    /// Fewest repetitions for which a section ends. A section has eight bytes in addition to its pixels.
    static constexpr std::uint32_t fewest = 2;

    /// Number of floats that are compared at a time.
    static constexpr std::size_t block = 16;

    static bool has_same_bits(float a, float b) {
        return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
    }
    /// Compares four floats with four others, bit by bit.
    static __m128i same_bits(const float* a, const float* b) {
        return _mm_cmpeq_epi32(_mm_castps_si128(_mm_loadu_ps(a)), _mm_castps_si128(_mm_loadu_ps(b)));
    }
    static bool all_are_equal(const float* a, const float* b) {
        __m128i same = same_bits(a, b);
        for (std::size_t k = 4; k < block; k += 4) same = _mm_and_si128(same, same_bits(a + k, b + k));
        return _mm_movemask_epi8(same) == 0xffff;
    }
    static bool none_are_equal(const float* a, const float* b) {
        __m128i same = same_bits(a, b);
        for (std::size_t k = 4; k < block; k += 4) same = _mm_or_si128(same, same_bits(a + k, b + k));
        return _mm_movemask_epi8(same) == 0;
    }
    /// Returns true if, in a block of floats from pixel `i` on, every float differs from that of the next pixel.
    bool all_differ(std::uint32_t i) const {
        const float* const floats = pixels_ + i * channels;
        return (i + 1) * channels + block <= count_ * channels && none_are_equal(floats, floats + channels);
    }
    bool equal(std::uint32_t i, std::uint32_t k) const {
        bool same = true;
        for (std::size_t c = 0; c < channels; ++c)
            same = same && has_same_bits(pixels_[i * channels + c], pixels_[k * channels + c]);
        return same;
    }

    const float* pixels_;
    std::uint32_t count_;
};

/// Returns an upper bound of the bytes of a row. Each section but the last one has at least three pixels with its
/// repetitions.
std::size_t greatest_size_of_row(std::size_t pixels, std::size_t channels) {
    return pixels * channels * sizeof(float) + (pixels / 3 + 1) * sizeof(SectionSize);
}

/// Writes a row of pixels to memory, and returns the end of what was written.
template <std::size_t channels>
char* put_row(char* to, const float* row, std::uint32_t count) {
    const RepetitionFinder<channels> finder(row, count);
    const auto put = [&to](const void* bytes, std::size_t size) {
        std::memcpy(to, bytes, size);
        to += size;
    };
    for (std::uint32_t begin = 0; begin < count;) {
        const std::uint32_t last = finder.find(begin);
        const SectionSize size{last + 1 - begin, finder.repetitions(last)};
        put(&size, sizeof size);
        put(row + begin * channels, size.pixels * channels * sizeof(float));
        begin += size.pixels + size.repetitions;
    }
    return to;
}

/// Reads a row of pixels that put_row<channels> has written.
template <std::size_t channels>
void get_row(ByteReader& reader, float* row, std::uint32_t count) {
    for (std::uint32_t begin = 0; begin < count;) {
        const auto [pixels, repetitions] = reader.get<SectionSize>();
        if (pixels == 0 || pixels > count - begin || repetitions > count - begin - pixels)
            throw InputError("a record has another number of pixels than its tile");
        reader.get_raw(row + begin * channels, pixels * channels * sizeof(float));
        begin += pixels;
        const float* const last = row + (begin - 1) * channels;
        for (const std::uint32_t end = begin + repetitions; begin < end; ++begin)  // copies also the bits of a NaN
            std::memcpy(row + begin * channels, last, channels * sizeof(float));
    }
}

/// Returns an upper bound of the bytes of the pixels of a tile.
std::size_t greatest_size_of_pixels(const Tile& tile, const Film& film) {
    std::size_t size = 0;
    for (const LayerInfo* layer : film.layers())
        size += (tile.y1 - tile.y0) * greatest_size_of_row(tile.x1 - tile.x0, layer->channels.size());
    return size;
}

}  // namespace

void put_pixels(ByteWriter& writer, const Tile& tile, const Film& film) {
    const Tile pixels = pixels_in_film(tile, film);
    if (has_no_pixels(pixels)) return;
    std::string& bytes = writer.bytes;
    const std::size_t begin = bytes.size();
    bytes.resize(begin + greatest_size_of_pixels(pixels, film));
    char* end = bytes.data() + begin;
    for (const LayerInfo* layer : film.layers()) {
        const std::size_t channels = layer->channels.size();
        for_each_pixel_row(pixels, film, film.plane(layer->name), channels, [&](const float* row, std::uint32_t count) {
            end = channels == 3 ? put_row<3>(end, row, count) : put_row<1>(end, row, count);
        });
    }
    bytes.resize(static_cast<std::size_t>(end - bytes.data()));
}

void get_pixels(ByteReader& reader, const Tile& tile, Film& film) {
    const Tile pixels = pixels_in_film(tile, film);
    if (has_no_pixels(pixels)) return;
    for (const LayerInfo* layer : film.layers()) {
        const std::size_t channels = layer->channels.size();
        // Complete rows are copied to the film, because writing pixel by pixel waits for memory more often.
        std::vector<float> row((pixels.x1 - pixels.x0) * channels);
        for_each_pixel_row(pixels, film, film.plane(layer->name), channels, [&](float* to, std::uint32_t count) {
            if (channels == 3) get_row<3>(reader, row.data(), count);
            else get_row<1>(reader, row.data(), count);
            if (to) std::memcpy(to, row.data(), count * channels * sizeof(float));
        });
    }
}

}  // namespace kagero
