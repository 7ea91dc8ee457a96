// The encoder of .png files. It uses libpng itself, because OpenImageIO loads many libraries that are not needed.
#include "film/codec.h"

#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstdlib>
#include <new>

namespace kagero {
namespace {

/// The bytes of a file, and the reason for a failure.
struct Output {
    std::vector<unsigned char>& bytes;
    std::string failure{};
};

/// Appends bytes to a file. Returns false if there is not enough memory.
bool append_to(std::vector<unsigned char>& file, const unsigned char* bytes, std::size_t count) try {
    file.insert(file.end(), bytes, bytes + count);
    return true;
} catch (const std::bad_alloc&) {
    return false;
}

void append(png_structp png, png_bytep bytes, png_size_t count) {
    if (!append_to(static_cast<Output*>(png_get_io_ptr(png))->bytes, bytes, count))
        png_error(png, "it requires more memory than is available");  // exceptions cannot pass through libpng
}

[[noreturn]] void fail(png_structp png, png_const_charp reason) {
    static_cast<Output*>(png_get_error_ptr(png))->failure = reason;
    png_longjmp(png, 1);
}

void ignore_warning(png_structp, png_const_charp) {}

/// Returns the level of compression that the attributes state, from 0 to 9; −1 is the default.
int compression_level(const PictureToEncode& picture) {
    for (const auto& [name, value] : picture.attributes)
        if (name == "png:compressionLevel") return std::clamp(std::atoi(value.c_str()), 0, 9);
    return -1;
}

/// Writes the picture. Functions of libpng leave this function by a jump when they fail, so it owns nothing.
void write(png_structp png, png_infop info, const PictureToEncode& picture, int level) {
    if (setjmp(png_jmpbuf(png))) return;
    png_set_compression_level(png, level);
    png_set_IHDR(png, info, png_uint_32(picture.width), png_uint_32(picture.height), 8, PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_ABSOLUTE);
    png_write_info(png, info);
    const auto* row = static_cast<const unsigned char*>(picture.pixels);
    for (int y = 0; y < picture.height; ++y, row += 3 * std::size_t(picture.width)) png_write_row(png, row);
    png_write_end(png, info);
}

std::string encode(const std::string&, const PictureToEncode& picture, std::vector<unsigned char>& file) {
    if (picture.samples != PictureToEncode::Samples::bytes || picture.channels != 3)
        return "only colours in bytes are written as PNG";
    Output output{file};
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &output, fail, ignore_warning);
    png_infop info = png ? png_create_info_struct(png) : nullptr;
    if (!info) output.failure = "libpng cannot be started";
    else {
        png_set_write_fn(png, &output, append, nullptr);
        write(png, info, picture, compression_level(picture));
    }
    png_destroy_write_struct(&png, &info);
    return output.failure;
}

constexpr Encoder png_encoder{codec_abi, encode};

}  // namespace
}  // namespace kagero

extern "C" __attribute__((visibility("default"))) const kagero::Encoder* kagero_encoder() {
    return &kagero::png_encoder;
}
