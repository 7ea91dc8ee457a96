// Tests of images in the precision of their files: the memory that they hold, and their texels and averages, compared
// with the values that were written.
#include "film/read_image.h"

#include "appearance/pyramid.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <random>

namespace kagero::test {
namespace {

namespace fs = std::filesystem;
using OIIO::TypeDesc;

/// A file of an image, and the number of bytes in which each component must be held.
struct FileCase {
    const char* name;
    const char* extension;
    TypeDesc type;
    int channels;
    int tile_size;  ///< 0 if the file has no tiles.
    std::size_t bytes;
};

std::ostream& operator<<(std::ostream& out, const FileCase& file) { return out << file.name; }

constexpr int columns = 40, rows = 24;

/// Returns the linear value of an sRGB-encoded value (IEC 61966-2-1).
double decoded(double value) { return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4); }

std::size_t bytes_of(const StoredImage& image) {
    return visit_texels(image, [&](const auto& texels) {
        const std::size_t count = std::visit(
            [](const auto& rgb) {
                if constexpr (requires { rgb.codes; }) return rgb.codes.size();
                else return rgb.size();
            },
            image.rgb);
        return count * sizeof *texels.stored;
    });
}

/// Removes the file at its end.
struct TemporaryFile {
    std::string path;

    explicit TemporaryFile(const std::string& extension)
        : path((fs::temp_directory_path() / ("kagero-stored-" + std::to_string(::getpid()) + extension)).string()) {}
    ~TemporaryFile() { fs::remove(path); }
};

void write_with_openimageio(const std::string& path, const OIIO::ImageSpec& spec, TypeDesc type, const void* pixels) {
    const auto out = OIIO::ImageOutput::create(path);
    ASSERT_TRUE(out && out->open(path, spec) && out->write_image(type, pixels) && out->close()) << OIIO::geterror();
}

class ImageFiles : public testing::TestWithParam<FileCase> {
protected:
    /// Writes a file of random components and reads it. Floats are multiples of 1/64 below 16, so that all types hold
    /// them exactly. Sets `expected` to the linear values, with three components per pixel.
    void SetUp() override {
        const FileCase& file = GetParam();
        const bool is_integer = file.type == TypeDesc::UINT8 || file.type == TypeDesc::UINT16;
        const unsigned greatest = file.type == TypeDesc::UINT8 ? 255 : file.type == TypeDesc::UINT16 ? 65535 : 1023;
        std::mt19937 random(4);
        std::vector<std::uint8_t> bytes;
        std::vector<std::uint16_t> words;
        std::vector<float> floats;
        for (int i = 0; i < columns * rows * file.channels; ++i) {
            const unsigned code = random() % (greatest + 1);
            bytes.push_back(static_cast<std::uint8_t>(code));
            words.push_back(static_cast<std::uint16_t>(code));
            floats.push_back(static_cast<float>(code) / 64);
            const double value = is_integer ? decoded(double(code) / greatest) : code / 64.0;
            if (file.channels <= 2 && i % file.channels == 0) expected.insert(expected.end(), 3, value);
            if (file.channels >= 3 && i % file.channels < 3) expected.push_back(value);
        }
        OIIO::ImageSpec spec(columns, rows, file.channels, file.type);
        spec.tile_width = spec.tile_height = file.tile_size;
        if (is_integer) spec.attribute("oiio:UnassociatedAlpha", 1);
        const TemporaryFile temporary(file.extension);
        if (file.type == TypeDesc::UINT8) write_with_openimageio(temporary.path, spec, file.type, bytes.data());
        else if (is_integer) write_with_openimageio(temporary.path, spec, file.type, words.data());
        else write_with_openimageio(temporary.path, spec, TypeDesc::FLOAT, floats.data());
        image = read_image(temporary.path, {});
        tolerance = is_integer ? 1e-6 : 0;  // integers are decoded with floats
    }
    double value(int x, int y, int c) const { return expected[std::size_t(3 * (y * columns + x) + c)]; }

    StoredImage image;
    std::vector<double> expected;
    double tolerance = 0;
};

TEST_P(ImageFiles, AreHeldInTheirOwnPrecision) {
    EXPECT_EQ(bytes_of(image), 3 * columns * rows * GetParam().bytes);
}

// At the centre of a texel, the interpolated colour is that of the texel.
TEST_P(ImageFiles, HaveTheWrittenColorsAtTexels) {
    ASSERT_EQ(image.width, columns);
    ASSERT_EQ(image.height, rows);
    const auto coarser = coarser_images(image, Mapping::plane);
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            const Float3 color =
                surface_texture_color(image, coarser, (x + 0.5) / columns, 1 - (y + 0.5) / rows, {}, clamp_both);
            // The position of a texel in units of texels is rounded, by less than 1e-13.
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(color[std::size_t(c)], value(x, y, c), tolerance + 1e-5) << x << " " << y << " " << c;
            visit_texels(image, [&](const auto& texels) {
                for (int c = 0; c < 3; ++c)
                    ASSERT_NEAR(texels[std::size_t(3 * (y * columns + x) + c)], value(x, y, c), tolerance);
            });
        }
}

// A patch with the size of 2 × 2 texels shows the first copy, whose texels are the means of 2 × 2 texels.
TEST_P(ImageFiles, HaveTheMeansOfTheWrittenColors) {
    const auto coarser = coarser_images(image, Mapping::plane);
    const UvPatch patch{{2.0 / columns, 0}, {0, 2.0 / rows}};
    for (int y = 0; y < rows / 2; ++y)
        for (int x = 0; x < columns / 2; ++x) {
            const Float3 color = surface_texture_color(image, coarser, (2 * x + 1.0) / columns,
                                                       1 - (2 * y + 1.0) / rows, patch, clamp_both);
            for (int c = 0; c < 3; ++c) {
                const double mean = 0.25 * (value(2 * x, 2 * y, c) + value(2 * x + 1, 2 * y, c) +
                                            value(2 * x, 2 * y + 1, c) + value(2 * x + 1, 2 * y + 1, c));
                ASSERT_NEAR(color[std::size_t(c)], mean, 1e-5) << x << " " << y << " " << c;
            }
        }
    double sum = 0;
    for (std::size_t i = 0; i < expected.size(); i += 3) sum += expected[i];
    EXPECT_NEAR(coarser.back().rgb[0], sum / (columns * rows), 1e-5);
}

INSTANTIATE_TEST_SUITE_P(
    Files, ImageFiles,
    testing::Values(FileCase{"Png8", ".png", TypeDesc::UINT8, 3, 0, 1},
                    FileCase{"Png8Alpha", ".png", TypeDesc::UINT8, 4, 0, 1},
                    FileCase{"Png8Grey", ".png", TypeDesc::UINT8, 1, 0, 1},
                    FileCase{"Png8GreyAlpha", ".png", TypeDesc::UINT8, 2, 0, 1},
                    FileCase{"Tiff8Tiles", ".tif", TypeDesc::UINT8, 3, 16, 1},
                    FileCase{"Png16", ".png", TypeDesc::UINT16, 3, 0, 2},
                    FileCase{"Tiff16TilesAlpha", ".tif", TypeDesc::UINT16, 4, 16, 2},
                    FileCase{"ExrHalf", ".exr", TypeDesc::HALF, 3, 0, 2},
                    FileCase{"ExrHalfTilesAlpha", ".exr", TypeDesc::HALF, 4, 16, 2},
                    FileCase{"ExrFloat", ".exr", TypeDesc::FLOAT, 3, 0, 4},
                    FileCase{"TiffFloatGrey", ".tif", TypeDesc::FLOAT, 1, 0, 4}),
    [](const auto& file) { return file.param.name; });

// The tiles of 16 × 16 pixels begin at the corner (−5, −7) of the data window, so that they are not aligned with the
// rows of the display window.
TEST(StoredImage, IsTheDisplayWindowOfTiles) {
    OIIO::ImageSpec spec(48, 48, 3, TypeDesc::HALF);
    spec.x = -5;
    spec.y = -7;
    spec.full_x = spec.full_y = 0;
    spec.full_width = spec.full_height = 32;
    spec.tile_width = spec.tile_height = 16;
    std::vector<float> stored;
    for (int i = 0; i < 48 * 48 * 3; ++i) stored.push_back(float(i % 2048));
    const TemporaryFile file(".exr");
    write_with_openimageio(file.path, spec, TypeDesc::FLOAT, stored.data());
    const StoredImage image = read_image(file.path, {});
    ASSERT_EQ(image.width, 32);
    ASSERT_EQ(image.height, 32);
    visit_texels(image, [&](const auto& texels) {
        for (int y = 0; y < 32; ++y)
            for (int i = 0; i < 3 * 32; ++i)
                ASSERT_EQ(texels[std::size_t(3 * 32 * y + i)], stored[std::size_t(3 * (48 * (y + 7) + 5) + i)]);
    });
}

// The file of 19 MB is read in more than one strip. The copies must not depend on the number of rows that are added at
// once.
TEST(StoredImage, IsReducedWhileItIsRead) {
    constexpr int width = 3001, height = 2101;
    std::vector<std::uint8_t> bytes;
    std::mt19937 random(5);
    for (int i = 0; i < 3 * width * height; ++i) bytes.push_back(static_cast<std::uint8_t>(random()));
    const TemporaryFile file(".ppm");
    write_with_openimageio(file.path, {width, height, 3, TypeDesc::UINT8}, TypeDesc::UINT8, bytes.data());
    ImageReader reader(file.path, {});
    ImageReduction reduction(width, height, Mapping::sphere);
    int strips = 0;
    for (; !reader.is_done(); ++strips) {
        reader.read_strip();
        reduction.add_rows(reader.image(), reader.rows_read());
    }
    EXPECT_GE(strips, 2);
    const std::vector<Image> images = reduction.take_images(), expected = coarser_images(read_image(file.path, {}));
    ASSERT_EQ(images.size(), expected.size());
    for (std::size_t i = 0; i < images.size(); ++i) EXPECT_TRUE(images[i].rgb == expected[i].rgb) << i;
}

TEST(StoredImage, IsRefusedWithThePixelOfAHalfThatIsNotFinite) {
    std::vector<float> values(3 * 4 * 2, 0.5f);
    values[3 * (4 + 2) + 1] = std::numeric_limits<float>::infinity();
    const TemporaryFile file(".exr");
    write_with_openimageio(file.path, {4, 2, 3, TypeDesc::HALF}, TypeDesc::FLOAT, values.data());
    try {
        read_image(file.path, {});
        ADD_FAILURE() << "an infinite value was read";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("not finite in pixel (2, 1)"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace kagero::test
