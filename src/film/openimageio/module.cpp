// What kagero asks of OpenImageIO; the only file that knows it.
#include "film/codec.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>
#include <OpenImageIO/strutil.h>

#include <cstdio>
#include <memory>
#include <new>
#include <stdexcept>

namespace kagero {
namespace {

/// Integer images hold sRGB unless they say otherwise; floating-point ones are linear.
bool is_srgb(const OIIO::ImageSpec& spec) {
    return spec.format != OIIO::TypeDesc::HALF && spec.format != OIIO::TypeDesc::FLOAT &&
           spec.format != OIIO::TypeDesc::DOUBLE && spec.get_string_attribute("oiio:ColorSpace", "sRGB") != "Linear";
}

std::string too_large(const DecodedImage& image) {
    if (image.width == 0) return "asks for more memory than there is before it says its size";
    return "says that it has " + std::to_string(image.width) + " x " + std::to_string(image.height) +
           " pixels, for which there is not enough memory";
}

/// Whether pixels are stored of a part of the picture alone, or of more than it: OpenEXR's data window is not its
/// display window.
bool is_stored_otherwise(const OIIO::ImageInput& input, const OIIO::ImageSpec& spec) {
    return input.format_name() == std::string("openexr") &&
           (spec.x != spec.full_x || spec.y != spec.full_y || spec.width != spec.full_width ||
            spec.height != spec.full_height);
}

/// Puts the stored pixels where they are in the picture: black is where there are none.
void place_in_picture(const OIIO::ImageSpec& spec, DecodedImage& image) {
    OIIO::ImageSpec stored(spec.width, spec.height, image.channels, OIIO::TypeDesc::FLOAT);
    stored.x = spec.x, stored.y = spec.y;
    OIIO::ROI shown = spec.roi_full();
    shown.chend = image.channels;
    image.width = shown.width(), image.height = shown.height();
    std::vector<float> pixels(std::size_t(shown.npixels()) * std::size_t(image.channels));
    OIIO::ImageBuf(stored, image.values.data()).get_pixels(shown, OIIO::TypeDesc::FLOAT, pixels.data());
    image.values = std::move(pixels);
}

/// Not all of the library's readers say what they miss.
std::string unreadable(const std::string& reason) {
    return "cannot be read as an image: " + (reason.empty() ? "it is truncated or damaged" : reason);
}

std::string read(const std::string& path, DecodedImage& image) try {
    // Alpha is dropped, so colours are wanted as stored and not multiplied by it.
    OIIO::ImageSpec wish;
    wish.attribute("oiio:UnassociatedAlpha", 1);
    const auto input = OIIO::ImageInput::open(path, &wish);
    if (!input) return unreadable(OIIO::geterror());
    const OIIO::ImageSpec spec = input->spec();
    if (spec.width <= 0 || spec.height <= 0 || spec.nchannels <= 0 || spec.depth > 1)
        return "is not a flat image with pixels";
    image.width = spec.width, image.height = spec.height, image.channels = spec.nchannels < 3 ? 1 : 3,
    image.srgb = is_srgb(spec);
    image.values.resize(std::size_t(spec.width) * std::size_t(spec.height) * std::size_t(image.channels));
    if (!input->read_image(0, 0, 0, image.channels, OIIO::TypeDesc::FLOAT, image.values.data()))
        return unreadable(input->geterror());
    // What a truncated file lacks may be no reason to fail for its reader, but a message.
    if (input->has_error()) return unreadable(input->geterror());
    if (is_stored_otherwise(*input, spec)) place_in_picture(spec, image);
    return {};
} catch (const std::bad_alloc&) {
    return too_large(image);
} catch (const std::length_error&) {
    return too_large(image);
}

OIIO::TypeDesc type_of(PictureToEncode::Samples samples) {
    return samples == PictureToEncode::Samples::bytes ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::FLOAT;
}

OIIO::ImageSpec spec_of(const PictureToEncode& picture) {
    OIIO::ImageSpec spec(picture.width, picture.height, picture.channels, type_of(picture.samples));
    if (!picture.names.empty()) spec.channelnames = picture.names;
    for (const bool half : picture.half)
        spec.channelformats.push_back(half ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT);
    if (picture.whole_width) {
        spec.x = picture.x, spec.y = picture.y;
        spec.full_width = picture.whole_width, spec.full_height = picture.whole_height;
    }
    for (const auto& [name, value] : picture.attributes) spec.attribute(name, value);
    if (picture.quality) spec.attribute("CompressionQuality", picture.quality);
    return spec;
}

std::string write_to(OIIO::ImageOutput* out, const std::string& name, const PictureToEncode& picture) {
    if (!out) return OIIO::geterror();
    const bool done =
        out->open(name, spec_of(picture)) && out->write_image(type_of(picture.samples), picture.pixels) && out->close();
    const std::string why = done ? "" : out->geterror();
    return done || !why.empty() ? why : "OpenImageIO does not say why";
}

/// TIFF goes back and forth in its file, which OpenImageIO 2.4 cannot do in memory: a file of its own then, without a
/// name.
std::string encode_tiff(const PictureToEncode& picture, std::vector<unsigned char>& bytes) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::tmpfile(), std::fclose);
    if (!file) return "no temporary file can be made";
    const std::string name = "/proc/self/fd/" + std::to_string(fileno(file.get()));
    if (const std::string why = write_to(OIIO::ImageOutput::create("tiff").get(), name, picture); !why.empty())
        return why;
    std::fseek(file.get(), 0, SEEK_END);
    bytes.resize(static_cast<std::size_t>(std::ftell(file.get())));
    std::rewind(file.get());
    return std::fread(bytes.data(), 1, bytes.size(), file.get()) == bytes.size()
               ? ""
               : "a temporary file cannot be read back";
}

/// Into memory: what writes a file by itself says nothing of a full disk, or ends the program.
std::string encode(const std::string& extension, const PictureToEncode& picture, std::vector<unsigned char>& file) {
    if (OIIO::Strutil::istarts_with(extension, ".tif")) return encode_tiff(picture, file);
    const std::string name = "picture" + extension;
    OIIO::Filesystem::IOVecOutput memory(file);
    return write_to(OIIO::ImageOutput::create(name, &memory).get(), name, picture);
}

std::string false_colors(const std::vector<float>& shares, std::vector<float>& rgb) {
    const int width = static_cast<int>(shares.size());
    std::vector<float> plane = shares;
    const OIIO::ImageBuf gray(OIIO::ImageSpec(width, 1, 1, OIIO::TypeDesc::FLOAT), plane.data());
    const OIIO::ImageBuf colored = OIIO::ImageBufAlgo::color_map(gray, 0, "inferno");
    rgb.resize(3 * shares.size());
    return colored.get_pixels(OIIO::ROI(0, width, 0, 1, 0, 1, 0, 3), OIIO::TypeDesc::FLOAT, rgb.data())
               ? ""
               : colored.geterror();
}

constexpr Codec offered{codec_abi, read, encode, false_colors};

}  // namespace
}  // namespace kagero

extern "C" __attribute__((visibility("default"))) const kagero::Codec* kagero_codec() { return &kagero::offered; }
