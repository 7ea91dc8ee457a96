// Tests of the modules that read and write images. They are loaded only by runs that need them, and other runs work
// without them.
#include "film/codec.h"
#include "modules/modules.h"
#include "tests/support/program.h"

#include <cmath>
#include <fstream>

namespace kagero::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* tiny_room = "'" KAGERO_SCENES "/room.toml' --size 4x4 --quiet -o ";

class ImageModule : public ProgramTest {
protected:
    /// Returns true if the dynamic linker opened the module, according to its log.
    bool is_opened_by(const std::string& arguments) const {
        EXPECT_EQ(run(arguments, "LD_DEBUG=files LD_DEBUG_OUTPUT=opened").status, 0) << arguments;
        bool opened = false;
        for (const auto& file : fs::directory_iterator(directory_))
            if (file.path().filename().string().starts_with("opened.")) {
                opened = opened || text_of(file.path()).find("kagero-images.so") != std::string::npos;
                fs::remove(file.path());
            }
        return opened;
    }
};

TEST_F(ImageModule, IsLoadedOnlyByRunsThatNeedIt) {
    EXPECT_TRUE(is_opened_by(std::string("render ") + tiny_room + "a.jpg"));
    EXPECT_FALSE(is_opened_by(std::string("render ") + tiny_room + "a.png"));
    EXPECT_FALSE(is_opened_by(std::string("render ") + tiny_room + "a.exr"));
    EXPECT_TRUE(is_opened_by("check '" KAGERO_SCENES "/galaxy.toml'"));  // the sky is an image
    EXPECT_FALSE(is_opened_by(std::string("render ") + tiny_room + "a.pfm"));
    EXPECT_FALSE(is_opened_by("check '" KAGERO_SCENES "/room.toml'"));
    write("rays.csv", "x,y,z,dx,dy,dz\n-1,0,0,1,0,0\n");
    EXPECT_FALSE(is_opened_by("trace '" KAGERO_SCENES "/galaxy.toml' --rays rays.csv -o ends.csv --quiet"));
    EXPECT_FALSE(is_opened_by("--help"));
}

// The program is copied to a folder without the image module.
TEST_F(ImageModule, IsNotNeededToWritePfm) {
    fs::create_directories(directory_ / "bin");
    fs::create_directories(directory_ / "lib/kagero");
    fs::copy(KAGERO_BINARY, directory_ / "bin");
    for (const IsaInfo& isa : find_isas())
        fs::create_symlink(isa.path, directory_ / "lib/kagero" / fs::path(isa.path).filename());
    const std::string program = (directory_ / "bin/kagero").string();
    EXPECT_EQ(run_program(program, std::string("render ") + tiny_room + "a.pfm").status, 0);
    const Outcome outcome = run_program(program, std::string("render ") + tiny_room + "a.png");
    EXPECT_EQ(outcome.status, 1);
    EXPECT_NE(outcome.err.find("kagero-images.so"), std::string::npos) << outcome.err;
    EXPECT_EQ(files(), (std::set<std::string>{"a.pfm", "bin", "lib"}));
}

class Encoders : public ProgramTest {
protected:
    /// Returns the components of a file with the given bytes, as OpenImageIO reads them. `Component` is their type.
    template <class Component>
    std::vector<Component> decoded(const std::string& name, const std::vector<unsigned char>& bytes) const {
        const std::string path = (directory_ / name).string();
        std::ofstream(path, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        std::unique_ptr<ImageFile> file;
        EXPECT_EQ(codec().open(path, nullptr, file), "");
        if (!file) return {};
        std::vector<Component> components(std::size_t(file->width) * std::size_t(file->height) *
                                          std::size_t(file->channels));
        for (int row = 0; row < file->height; row += file->strip_height)
            EXPECT_EQ(file->read(row, std::min(row + file->strip_height, file->height),
                                 &components[std::size_t(row) * std::size_t(file->width * file->channels)]),
                      "");
        return components;
    }
};

// Pictures with 32-bit and with 16-bit floats, beyond whose range some numbers are, and a crop.
TEST_F(Encoders, WriteExrAsOpenImageIODoes) {
    constexpr int width = 37, height = 29;
    std::vector<float> pixels(3 * width * height);
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = std::ldexp(std::sin(float(i)), int(i % 60) - 40);
    pixels[0] = std::nanf("");
    PictureToEncode picture{width, height, 3, PictureToEncode::Samples::floats, pixels.data()};
    picture.attributes = {{"compression", "zip"}, {"DateTime", ""}, {"kagero/scene", "text"}};
    picture.names = {"R", "G", "B"};
    for (const bool half : {false, true}) {
        picture.half = {half, half, half};
        std::vector<unsigned char> direct, with_openimageio;
        ASSERT_EQ(encode_picture(".exr", picture, direct), "");
        ASSERT_EQ(codec().encode(".exr", picture, with_openimageio), "");
        using Half = std::uint16_t;
        if (half) EXPECT_EQ(decoded<Half>("a.exr", direct), decoded<Half>("b.exr", with_openimageio));
        else EXPECT_EQ(decoded<std::uint32_t>("a.exr", direct), decoded<std::uint32_t>("b.exr", with_openimageio));
        const std::string text(direct.begin(), direct.end());
        EXPECT_NE(text.find("kagero/scene"), std::string::npos);
    }
    picture.x = 5;
    picture.y = 7;
    picture.whole_width = picture.whole_height = 100;
    std::vector<unsigned char> crop, with_openimageio;
    ASSERT_EQ(encode_picture(".exr", picture, crop), "");
    ASSERT_EQ(codec().encode(".exr", picture, with_openimageio), "");
    EXPECT_EQ(decoded<std::uint16_t>("a.exr", crop), decoded<std::uint16_t>("b.exr", with_openimageio));
}

TEST_F(Encoders, WritePngThatOpenImageIOReads) {
    constexpr int width = 41, height = 23;
    std::vector<unsigned char> pixels(3 * width * height);
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<unsigned char>(i * i / 7);
    const PictureToEncode picture{width, height, 3, PictureToEncode::Samples::bytes, pixels.data()};
    for (const char* extension : {".png", ".PNG"}) {
        std::vector<unsigned char> file;
        ASSERT_EQ(encode_picture(extension, picture, file), "");
        EXPECT_EQ(decoded<unsigned char>("a.png", file), pixels);
    }
}

}  // namespace
}  // namespace kagero::test
