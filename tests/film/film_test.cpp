// Tests of films and picture files: a written picture is read again in every format, and failed writes leave no files.
#include "film/write_film.h"
#include "film/film.h"

#include "error.h"
#include "film/read_image.h"
#include "tests/support/linear_image.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <thread>

namespace {

using namespace kagero;
namespace fs = std::filesystem;

/// Fixture with a temporary folder, which is removed after the test.
class FilmOnDisk : public testing::Test {
protected:
    void SetUp() override {
        const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
        directory_ = fs::temp_directory_path() / ("kagero-film-" + test + "-" + std::to_string(::getpid()));
        fs::create_directories(directory_);
    }
    void TearDown() override { fs::remove_all(directory_); }
    std::string path(const std::string& name) const { return (directory_ / name).string(); }
    std::size_t file_count() const {
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(directory_), fs::directory_iterator()));
    }
    fs::path directory_;
};

constexpr std::uint32_t width = 5, height = 3;

/// Returns a film in which all values differ. Colours lie between 0 and 1.
Film numbered_film(const std::vector<std::string>& layers) {
    Film film(width, height, layers);
    for (const LayerInfo* layer : film.layers())
        for (std::uint32_t y = 0; y < height; ++y)
            for (std::uint32_t x = 0; x < width; ++x)
                for (std::size_t c = 0; c < layer->channels.size(); ++c) {
                    const float number = static_cast<float>((y * width + x) * layer->channels.size() + c);
                    film.pixel(layer->name, x, y)[c] = layer->half() ? number / 64 : 1000 + number;
                }
    return film;
}

std::string bytes_of(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

double decode_srgb(int code) {
    const double x = code / 255.0;
    return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
}

/// Returns the greatest error of a linear colour that is rounded to an 8-bit sRGB code, plus 1 %. This error occurs
/// between codes 254 and 255, where the slope of the decoding curve is greatest.
double max_srgb_rounding_error() {
    return 0.5 * (decode_srgb(255) - decode_srgb(254)) * 1.01;
}

TEST(Film, HasEachRequestedLayerOnce) {
    Film film(4, 2, {"color", "steps", "color"});
    ASSERT_EQ(film.layers().size(), 2u);
    EXPECT_TRUE(film.has("steps"));
    EXPECT_FALSE(film.has("depth"));
    EXPECT_EQ(film.plane("depth"), nullptr);
    EXPECT_EQ(film.pixel("color", 1, 1) - film.plane("color"), (4 + 1) * 3);
    EXPECT_EQ(film.pixel("steps", 1, 1) - film.plane("steps"), 4 + 1);
}

TEST(Film, RefusesAnUnknownLayerWithANearMatch) {
    try {
        Film film(1, 1, {"stps"});
        FAIL();
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("'steps'"), std::string::npos) << error.what();
    }
}

TEST_F(FilmOnDisk, HasEveryLayerAndAttributeAsExr) {
    std::vector<std::string> names;
    for (const LayerInfo& layer : all_layers()) names.push_back(layer.name);
    Film film = numbered_film(names);
    write_film(film, path("all.exr"), {{"isa", "none"}, {"scene", "two\nlines"}});

    const auto in = OIIO::ImageInput::open(path("all.exr"));
    ASSERT_TRUE(in) << OIIO::geterror();
    const OIIO::ImageSpec& spec = in->spec();
    EXPECT_EQ(spec.get_string_attribute("kagero/isa"), "none");
    EXPECT_EQ(spec.get_string_attribute("kagero/scene"), "two\nlines");
    EXPECT_EQ(spec.get_string_attribute("compression"), "zip");
    std::vector<float> pixels(std::size_t{width} * height * spec.nchannels);
    ASSERT_TRUE(in->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, pixels.data()));

    int channels = 0;
    for (const LayerInfo& layer : all_layers())
        for (std::size_t c = 0; c < layer.channels.size(); ++c, ++channels) {
            const int channel = spec.channelindex(layer.name + "." + layer.channels[c]);
            ASSERT_GE(channel, 0) << layer.name << "." << layer.channels[c];
            EXPECT_EQ(spec.channelformat(channel), layer.half() ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT)
                << layer.name;
            for (std::uint32_t i = 0; i < width * height; ++i)
                EXPECT_EQ(pixels[i * spec.nchannels + channel], film.pixel(layer.name, i % width, i / width)[c])
                    << layer.name;
        }
    EXPECT_EQ(spec.nchannels, channels);
}

// Colours are stored as half floats, whose greatest value is 65504. The layer `steps` is stored as float.
TEST_F(FilmOnDisk, ClampsColorsToTheRangeOfHalfFloats) {
    Film film(1, 1, {"color", "steps"});
    for (int c = 0; c < 3; ++c) film.plane("color")[c] = c == 1 ? -1e30f : 1e30f;
    film.plane("steps")[0] = 1e6f;
    write_film(film, path("bright.exr"), {});
    const auto in = OIIO::ImageInput::open(path("bright.exr"));
    ASSERT_TRUE(in);
    float pixels[4];
    ASSERT_TRUE(in->read_image(0, 0, 0, 4, OIIO::TypeDesc::FLOAT, pixels));
    EXPECT_EQ(pixels[in->spec().channelindex("color.R")], 65504.0f);
    EXPECT_EQ(pixels[in->spec().channelindex("color.G")], -65504.0f);
    EXPECT_EQ(pixels[in->spec().channelindex("steps.V")], 1e6f);
}

TEST_F(FilmOnDisk, IsReadAsTheWrittenColors) {
    const Film film = numbered_film({"color", "steps"});
    for (const char* name : {"a.png", "a.tif", "a.bmp", "a.ppm", "a.PNG", "a.pfm"}) {
        write_film(film, path(name), {});
        const Image image = test::linear_image(read_image(path(name), {}));
        ASSERT_EQ(image.width, static_cast<int>(width)) << name;
        ASSERT_EQ(image.height, static_cast<int>(height)) << name;
        const bool exact = std::string(name) == "a.pfm";
        for (std::size_t i = 0; i < image.rgb.size(); ++i)
            EXPECT_NEAR(image.rgb[i], film.plane("color")[i], exact ? 0 : max_srgb_rounding_error())
                << name << " " << i;
    }
}

TEST_F(FilmOnDisk, IsRefusedIfTruncated) {
    Film film(64, 64, {"color"});
    for (std::size_t i = 0; i < 3 * 64 * 64; ++i) film.plane("color")[i] = static_cast<float>(i * 37 % 101) / 100;
    for (const char* name : {"a.jpg", "a.png", "a.tif", "a.exr", "a.hdr"}) {
        write_film(film, path(name), {});
        EXPECT_NO_THROW(read_image(path(name), {})) << name;
        fs::resize_file(path(name), fs::file_size(path(name)) * 6 / 10);
        EXPECT_THROW(read_image(path(name), {}), InputError) << name;
    }
}

// The format RGBE has a shared exponent and no sign. Negative values must be stored as 0.
TEST_F(FilmOnDisk, HasNoNegativeValuesAsHdr) {
    Film film(2, 1, {"color"});
    const float values[6] = {-0.5f, 0.25f, 1.0f, 5.0f, 0.0f, 0.5f};
    std::copy(std::begin(values), std::end(values), film.plane("color"));
    write_film(film, path("light.hdr"), {});
    const Image image = test::linear_image(read_image(path("light.hdr"), {}));
    EXPECT_EQ(image.rgb[0], 0);
    EXPECT_NEAR(image.rgb[1], 0.25, 0.005);
    EXPECT_NEAR(image.rgb[3], 5, 0.05);
}

// Pixels that are not colours of an upright picture would otherwise be used as if they were.
TEST_F(FilmOnDisk, IsNotReadFromOtherPixels) {
    const auto expect_refusal = [&](const std::string& name, const std::string& reason) {
        try {
            read_image(path(name), {});
            ADD_FAILURE() << name << " was read";
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(reason), std::string::npos) << error.what();
        }
    };
    // The first row of this file is the lowest one of the picture.
    std::ofstream(path("mirrored.hdr"), std::ios::binary)
        << "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n+Y 2 +X 1\n" + std::string("\x80\0\0\x81\0\x80\0\x81", 8);
    expect_refusal("mirrored.hdr", "is stored rotated or mirrored (orientation 4 of Exif)");
    const auto write = [&](const std::string& name, OIIO::TypeDesc type, const std::vector<std::string>& channels) {
        OIIO::ImageSpec spec(2, 2, int(channels.size()), type);
        spec.channelnames = channels;
        spec.alpha_channel = channels[0] == "A" ? 0 : -1;
        spec.z_channel = channels[0] == "Z" ? 0 : -1;
        const std::vector<float> values(4 * channels.size(), 1.0f);
        const auto out = OIIO::ImageOutput::create("any.exr");
        ASSERT_TRUE(out && out->open(path(name), spec) && out->write_image(OIIO::TypeDesc::FLOAT, values.data()) &&
                    out->close());
    };
    write("integers.exr", OIIO::TypeDesc::UINT32, {"R", "G", "B"});
    expect_refusal("integers.exr", "has channels of 32-bit integers");
    for (const std::string channel : {"Z", "A"}) {
        write(channel + ".exr", OIIO::TypeDesc::FLOAT, {channel});
        expect_refusal(channel + ".exr", "has the channels " + channel);
    }
    write("layers.exr", OIIO::TypeDesc::FLOAT, {"a.R", "a.G", "a.B", "b.R", "b.G", "b.B"});
    expect_refusal("layers.exr", "store the layer to use in a file of its own");
    write("layer.exr", OIIO::TypeDesc::FLOAT, {"a.R", "a.G", "a.B"});
    EXPECT_EQ(read_image(path("layer.exr"), {}).width, 2);
}

// The display window has 4 × 3 pixels. The data window has the columns 2 to 5 and the rows −1 to 1. Pixels outside the
// data window must be read as 0. A picture with too many pixels must be refused.
TEST_F(FilmOnDisk, IsReadWithTheDisplayWindowOfExr) {
    OIIO::ImageSpec spec(4, 3, 3, OIIO::TypeDesc::FLOAT);
    spec.x = 2;
    spec.y = -1;
    spec.full_x = spec.full_y = 0;
    spec.full_width = 4;
    spec.full_height = 3;
    float stored[36];
    for (int i = 0; i < 36; ++i) stored[i] = float(i + 1);
    const auto out = OIIO::ImageOutput::create("part.exr");
    ASSERT_TRUE(out && out->open(path("part.exr"), spec) && out->write_image(OIIO::TypeDesc::FLOAT, stored) &&
                out->close())
        << out->geterror();
    const Image image = test::linear_image(read_image(path("part.exr"), {}));
    ASSERT_EQ(image.width, 4);
    ASSERT_EQ(image.height, 3);
    for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 4; ++x)
            for (int c = 0; c < 3; ++c) {
                const float expected = x >= 2 && y <= 1 ? stored[3 * (4 * (y + 1) + x - 2) + c] : 0;
                EXPECT_EQ(image.rgb[std::size_t(3 * (4 * y + x) + c)], expected) << x << " " << y << " " << c;
            }
    spec.full_width = spec.full_height = (1 << 30) - 1;
    ASSERT_TRUE(out->open(path("large.exr"), spec) && out->write_image(OIIO::TypeDesc::FLOAT, stored) && out->close())
        << out->geterror();
    try {
        read_image(path("large.exr"), {});
        ADD_FAILURE() << "a picture with too many pixels was read";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("1073741823 x 1073741823 pixels"), std::string::npos) << error.what();
    }
}

// The data window is the rectangle of the crop, and the display window is the whole picture.
TEST_F(FilmOnDisk, HasThePositionOfACropAsExr) {
    write_film(Film(2, 3, {"color"}, {10, 20, 64, 48}), path("crop.exr"), {});
    const auto in = OIIO::ImageInput::open(path("crop.exr"));
    ASSERT_TRUE(in) << OIIO::geterror();
    const OIIO::ImageSpec& spec = in->spec();
    const auto window = [](int x, int y, int wide, int high) { return std::vector{x, y, wide, high}; };
    EXPECT_EQ(window(spec.x, spec.y, spec.width, spec.height), window(10, 20, 2, 3));
    EXPECT_EQ(window(spec.full_x, spec.full_y, spec.full_width, spec.full_height), window(0, 0, 64, 48));
}

// Values outside [0, 1] are clamped, and NaN is stored as 0. The last value is the linear colour of the code 127.5.
TEST_F(FilmOnDisk, HasClampedCodesOfEightBits) {
    Film film(2, 1, {"color"});
    const float values[6] = {-1.0f, 0.0f, 1.0f, 5.0f, std::nanf(""), 0.2140411f};
    std::copy(std::begin(values), std::end(values), film.plane("color"));
    write_film(film, path("codes.png"), {});
    const auto in = OIIO::ImageInput::open(path("codes.png"));
    ASSERT_TRUE(in);
    unsigned char codes[6];
    ASSERT_TRUE(in->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, codes));
    EXPECT_EQ(codes[0], 0);
    EXPECT_EQ(codes[1], 0);
    EXPECT_EQ(codes[2], 255);
    EXPECT_EQ(codes[3], 255);
    EXPECT_EQ(codes[4], 0);
    EXPECT_NEAR(codes[5], 127.5, 0.51);
}

// Files must not contain the time of writing, which some formats store in seconds.
TEST_F(FilmOnDisk, HasTheSameBytesAtAnyTime) {
    const Film film = numbered_film({"color", "steps"});
    const auto extensions = {".exr", ".png", ".jpg", ".tif", ".pfm", ".hdr"};
    for (const std::string extension : extensions) write_film(film, path("one" + extension), {});
    std::this_thread::sleep_for(std::chrono::milliseconds(1100));
    for (const std::string extension : extensions) {
        write_film(film, path("two" + extension), {});
        EXPECT_EQ(bytes_of(path("one" + extension)), bytes_of(path("two" + extension))) << extension;
    }
}

TEST_F(FilmOnDisk, LeavesNoOtherFiles) {
    const Film film = numbered_film({"color"});
    std::ofstream(path("a.png")) << "previous file";
    write_film(film, path("a.png"), {});
    EXPECT_EQ(file_count(), 1u);
    EXPECT_EQ(read_image(path("a.png"), {}).width, static_cast<int>(width));

    EXPECT_THROW(write_film(film, path("missing/a.png"), {}), RunError);
    EXPECT_THROW(write_film(numbered_film({"steps"}), path("b.png"), {}), RunError);
    EXPECT_EQ(file_count(), 1u);
}

TEST_F(FilmOnDisk, IsRefusedBeforehandIfItCannotBeWritten) {
    EXPECT_NO_THROW(check_writable(path("a.exr"), {"color"}, 8, 6));
    EXPECT_NO_THROW(check_writable(path("a.exr"), {"steps"}, 8, 6));
    EXPECT_THROW(check_writable(path("a.png"), {"steps"}, 8, 6), InputError);
    EXPECT_THROW(check_writable(path("a.xyz"), {"color"}, 8, 6), InputError);
    EXPECT_THROW(check_writable(path("a"), {"color"}, 8, 6), InputError);
    EXPECT_THROW(check_writable(path("missing/a.exr"), {"color"}, 8, 6), InputError);
    fs::create_directory(path("folder.exr"));
    EXPECT_THROW(check_writable(path("folder.exr"), {"color"}, 8, 6), InputError);
    for (const auto& [name, greatest_size] :
         {std::pair{"a.jpg", 65500u}, std::pair{"a.webp", 16383u}, std::pair{"a.tga", 65535u}}) {
        EXPECT_NO_THROW(check_writable(path(name), {"color"}, 1, greatest_size)) << name;
        EXPECT_THROW(check_writable(path(name), {"color"}, greatest_size + 1, 1), InputError) << name;
    }
    EXPECT_NO_THROW(check_writable(path("a.exr"), {"color"}, 1u << 20, 1));
}

/// Returns the message with which an image is refused; empty if it is read.
std::string refusal_of_image(const std::string& path) {
    try {
        read_image(path, {});
    } catch (const InputError& error) {
        return error.what();
    }
    return {};
}

// The rows of a PFM file run from the bottom to the top.
TEST_F(FilmOnDisk, IsRefusedWithThePixelOfANumberThatIsNotFinite) {
    std::vector<float> values(3 * 4 * 2, 0.5f);
    values[3 * (4 + 2) + 1] = std::numeric_limits<float>::quiet_NaN();
    std::ofstream file(path("nan.pfm"), std::ios::binary);
    file << "PF\n4 2\n-1.0\n";
    file.write(reinterpret_cast<const char*>(values.data()), std::streamsize(4 * values.size()));
    file.close();
    EXPECT_NE(refusal_of_image(path("nan.pfm")).find("not finite in pixel (2, 0)"), std::string::npos)
        << refusal_of_image(path("nan.pfm"));
}

TEST_F(FilmOnDisk, IsRefusedWithoutTheChannelsOfAColor) {
    OIIO::ImageSpec spec(2, 2, 2, OIIO::TypeDesc::FLOAT);
    spec.channelnames = {"R", "G"};
    spec.alpha_channel = -1;
    const std::vector<float> values(8, 0.5f);
    const auto out = OIIO::ImageOutput::create(path("two.exr"));
    ASSERT_TRUE(out && out->open(path("two.exr"), spec));
    ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, values.data()));
    out->close();
    const std::string message = refusal_of_image(path("two.exr"));
    EXPECT_NE(message.find("has the channels R, G"), std::string::npos) << message;
}

}  // namespace
