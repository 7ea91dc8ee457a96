// Pixels of tiles have the same bits after they were written and read, and few bytes if many of them are equal.
#include "parts/tile_pixels.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace kagero::test {
namespace {

constexpr CropWindow window{33, 5, 200, 150};  // the film begins within tiles
const std::vector<std::string> layers{"color", "steps", "depth"};

Film film_with(const std::vector<std::string>& names = layers, Planes planes = Planes::allocated) {
    return Film(70, 50, names, window, {}, planes);
}

/// Fills the film with runs of equal pixels. `equal_share` is the probability that a pixel equals the one before it.
void fill(Film& film, double equal_share, std::mt19937& random) {
    const float special[] = {0.0f, -0.0f, std::numeric_limits<float>::quiet_NaN(),
                             std::numeric_limits<float>::infinity(), std::numeric_limits<float>::denorm_min()};
    std::uniform_real_distribution<double> share(0, 1);
    for (const LayerInfo* layer : film.layers()) {
        const std::size_t channels = layer->channels.size(), count = std::size_t{film.width()} * film.height();
        float* const plane = film.plane(layer->name);
        for (std::size_t i = 0; i < count * channels; i += channels) {
            const bool repeats = i > 0 && share(random) < equal_share;
            for (std::size_t c = 0; c < channels; ++c)
                plane[i + c] = repeats               ? plane[i + c - channels]
                               : share(random) < 0.1 ? special[random() % std::size(special)]
                                                     : static_cast<float>(share(random));
        }
    }
}

/// Tiles of a grid of 32 × 32 pixels that cover the film, and one tile beside it.
std::vector<Tile> tiles() {
    std::vector<Tile> all{{160, 0, 192, 32}};
    for (std::uint32_t y = 0; y < 64; y += 32)
        for (std::uint32_t x = 32; x < 128; x += 32) all.push_back({x, y, x + 32, y + 32});
    return all;
}

TEST(TilePixels, KeepEveryBit) {
    std::mt19937 random(7);
    for (const double equal_share : {0.0, 0.5, 0.9, 0.99, 1.0}) {
        Film film = film_with(), copy = film_with();
        fill(film, equal_share, random);
        for (const Tile& tile : tiles()) {
            ByteWriter writer;
            put_pixels(writer, tile, film);
            ByteReader reader(writer.bytes), skipped(writer.bytes);
            get_pixels(reader, tile, copy);
            EXPECT_TRUE(reader.empty());
            Film without_planes = film_with(layers, Planes::none);
            get_pixels(skipped, tile, without_planes);
            EXPECT_TRUE(skipped.empty());
        }
        for (const LayerInfo* layer : film.layers())
            EXPECT_EQ(std::memcmp(film.plane(layer->name), copy.plane(layer->name),
                                  std::size_t{70} * 50 * layer->channels.size() * sizeof(float)),
                      0)
                << layer->name << ", " << equal_share;
    }
}

TEST(TilePixels, AreFewBytesIfTheyAreEqual) {
    std::mt19937 random(7);
    const Tile tile{64, 0, 96, 32};  // 27 rows of it are in the film
    const std::size_t rows = 27, floats = 32 * rows * 3, sizes = 4 * rows;
    for (const auto& [equal_share, fewest, most] : {std::tuple{0.0, floats * 4 + sizes, floats * 4 + sizes},
                                                    std::tuple{1.0, rows * 12 + sizes, rows * 12 + sizes}}) {
        Film film = film_with({"color"});
        fill(film, equal_share, random);
        ByteWriter writer;
        put_pixels(writer, tile, film);
        EXPECT_GE(writer.bytes.size(), fewest) << equal_share;
        EXPECT_LE(writer.bytes.size(), most) << equal_share;
    }
}

TEST(TilePixels, OfAnotherTileAreRefused) {
    std::mt19937 random(7);
    Film film = film_with();
    fill(film, 0.5, random);
    const Tile small{64, 0, 96, 16}, large{64, 0, 96, 32};
    ByteWriter writer;
    put_pixels(writer, large, film);
    ByteReader reader(writer.bytes);
    EXPECT_THROW(get_pixels(reader, small, film), InputError);
    ByteReader shortened(std::string_view(writer.bytes).substr(0, writer.bytes.size() - 1));
    EXPECT_THROW(get_pixels(shortened, large, film), InputError);
    ByteWriter none;  // a row without pixels
    none.put(std::uint32_t{0});
    ByteReader empty_row(none.bytes);
    EXPECT_THROW(get_pixels(empty_row, large, film), InputError);
}

}  // namespace
}  // namespace kagero::test
