// The image module. This is the only file that uses OpenImageIO.
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

/// Returns true if the values are sRGB-encoded. Floating-point images are linear. Integer images are sRGB-encoded
/// unless their metadata states that they are linear.
bool is_srgb(const OIIO::ImageSpec& spec) {
    return spec.format != OIIO::TypeDesc::HALF && spec.format != OIIO::TypeDesc::FLOAT &&
           spec.format != OIIO::TypeDesc::DOUBLE && spec.get_string_attribute("oiio:ColorSpace", "sRGB") != "Linear";
}

/// Returns the message for an image that does not fit into memory.
std::string too_large(const DecodedImage& image) {
    if (image.width == 0) return "requires more memory than is available, even before its size is read";
    return "states a size of " + std::to_string(image.width) + " x " + std::to_string(image.height) +
           " pixels, which requires more memory than is available";
}

/// Returns true if an OpenEXR file stores the pixels of a data window that differs from the display window, which is
/// the picture.
bool has_partial_data_window(const OIIO::ImageInput& input, const OIIO::ImageSpec& spec) {
    return input.format_name() == std::string("openexr") &&
           (spec.x != spec.full_x || spec.y != spec.full_y || spec.width != spec.full_width ||
            spec.height != spec.full_height);
}

/// Changes an image of the data window to an image of the display window. Pixels outside the data window become black.
void expand_to_display_window(const OIIO::ImageSpec& spec, DecodedImage& image) {
    OIIO::ImageSpec stored(spec.width, spec.height, image.channels, OIIO::TypeDesc::FLOAT);
    stored.x = spec.x;
    stored.y = spec.y;
    OIIO::ROI display = spec.roi_full();
    display.chend = image.channels;
    image.width = display.width();
    image.height = display.height();
    std::vector<float> pixels(std::size_t(display.npixels()) * std::size_t(image.channels));
    OIIO::ImageBuf(stored, image.values.data()).get_pixels(display, OIIO::TypeDesc::FLOAT, pixels.data());
    image.values = std::move(pixels);
}

/// Returns the message for an image whose channels are neither grey nor red, green and blue; empty if they are. Alpha
/// and further channels are permitted and ignored.
std::string unexpected_channels(const OIIO::ImageSpec& spec) {
    const auto is_named = [&](int channel, const char* name) {
        const std::string& full = spec.channelnames[std::size_t(channel)];  // such as R or color.R
        return OIIO::Strutil::iequals(full.substr(full.rfind('.') + 1), name);
    };
    const bool is_grey = spec.nchannels == 1 || (spec.nchannels == 2 && spec.alpha_channel == 1),
               is_color = spec.nchannels >= 3 && is_named(0, "R") && is_named(1, "G") && is_named(2, "B");
    if (is_grey || is_color) return {};
    return "has the channels " + OIIO::Strutil::join(spec.channelnames, ", ") +
           "; it must have one channel, or R, G and B, each with or without alpha";
}

/// Returns the message for an unreadable file. Not all readers of OpenImageIO state a reason.
std::string unreadable_message(const std::string& reason) {
    return "cannot be read as an image: " + (reason.empty() ? "it is truncated or damaged" : reason);
}

/// Reads an image file; implements Codec::read.
std::string read(const std::string& path, DecodedImage& image) try {
    // Alpha is ignored, so colours are requested as stored, not multiplied by alpha.
    OIIO::ImageSpec configuration;
    configuration.attribute("oiio:UnassociatedAlpha", 1);
    const auto input = OIIO::ImageInput::open(path, &configuration);
    if (!input) return unreadable_message(OIIO::geterror());
    const OIIO::ImageSpec spec = input->spec();
    if (spec.width <= 0 || spec.height <= 0 || spec.nchannels <= 0 || spec.depth > 1)
        return "is not a two-dimensional image with at least one pixel";
    if (const std::string message = unexpected_channels(spec); !message.empty()) return message;
    image.width = spec.width;
    image.height = spec.height;
    image.channels = spec.nchannels < 3 ? 1 : 3;
    image.srgb = is_srgb(spec);
    image.values.resize(std::size_t(spec.width) * std::size_t(spec.height) * std::size_t(image.channels));
    if (!input->read_image(0, 0, 0, image.channels, OIIO::TypeDesc::FLOAT, image.values.data()))
        return unreadable_message(input->geterror());
    // Some readers report a truncated file only by an error message, without failing.
    if (input->has_error()) return unreadable_message(input->geterror());
    if (has_partial_data_window(*input, spec)) expand_to_display_window(spec, image);
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
        spec.x = picture.x;
        spec.y = picture.y;
        spec.full_width = picture.whole_width;
        spec.full_height = picture.whole_height;
    }
    for (const auto& [name, value] : picture.attributes) spec.attribute(name, value);
    if (picture.quality) spec.attribute("CompressionQuality", picture.quality);
    return spec;
}

/// Writes a picture through an OpenImageIO output. Returns "" on success, otherwise the reason for the failure.
std::string write_to(OIIO::ImageOutput* out, const std::string& name, const PictureToEncode& picture) {
    if (!out) return OIIO::geterror();
    const bool done =
        out->open(name, spec_of(picture)) && out->write_image(type_of(picture.samples), picture.pixels) && out->close();
    const std::string reason = done ? "" : out->geterror();
    return done || !reason.empty() ? reason : "OpenImageIO states no reason";
}

/// Encodes TIFF in an unnamed temporary file. The TIFF writer seeks in its file, which OpenImageIO 2.4 does not support
/// in memory.
std::string encode_tiff(const PictureToEncode& picture, std::vector<unsigned char>& bytes) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::tmpfile(), std::fclose);
    if (!file) return "a temporary file cannot be created";
    const std::string name = "/proc/self/fd/" + std::to_string(fileno(file.get()));
    if (const std::string reason = write_to(OIIO::ImageOutput::create("tiff").get(), name, picture); !reason.empty())
        return reason;
    std::fseek(file.get(), 0, SEEK_END);
    bytes.resize(static_cast<std::size_t>(std::ftell(file.get())));
    std::rewind(file.get());
    return std::fread(bytes.data(), 1, bytes.size(), file.get()) == bytes.size()
               ? ""
               : "a temporary file cannot be read back";
}

/// Encodes a picture in memory; implements Codec::encode. Some writers of OpenImageIO ignore a full disk, or terminate
/// the program, if they write to a file.
std::string encode(const std::string& extension, const PictureToEncode& picture, std::vector<unsigned char>& file) {
    if (OIIO::Strutil::istarts_with(extension, ".tif")) return encode_tiff(picture, file);
    const std::string name = "picture" + extension;
    OIIO::Filesystem::IOVecOutput memory(file);
    return write_to(OIIO::ImageOutput::create(name, &memory).get(), name, picture);
}

/// Maps numbers to false colours; implements Codec::false_colors.
std::string false_colors(const std::vector<float>& numbers, std::vector<float>& rgb) {
    const int width = static_cast<int>(numbers.size());
    std::vector<float> plane = numbers;
    const OIIO::ImageBuf gray(OIIO::ImageSpec(width, 1, 1, OIIO::TypeDesc::FLOAT), plane.data());
    const OIIO::ImageBuf colored = OIIO::ImageBufAlgo::color_map(gray, 0, "inferno");
    rgb.resize(3 * numbers.size());
    return colored.get_pixels(OIIO::ROI(0, width, 0, 1, 0, 1, 0, 3), OIIO::TypeDesc::FLOAT, rgb.data())
               ? ""
               : colored.geterror();
}

constexpr Codec image_module{codec_abi, read, encode, false_colors};

}  // namespace
}  // namespace kagero

extern "C" __attribute__((visibility("default"))) const kagero::Codec* kagero_codec() { return &kagero::image_module; }
