// The image module. This is the only file that uses OpenImageIO.
#include "film/codec.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>
#include <OpenImageIO/strutil.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <numeric>
#include <stdexcept>

namespace kagero {
namespace {

/// Returns true if the values are sRGB-encoded. Floating-point images are linear. Integer images are sRGB-encoded
/// unless their metadata states that they are linear.
bool is_srgb(const OIIO::ImageSpec& spec) {
    return spec.format != OIIO::TypeDesc::HALF && spec.format != OIIO::TypeDesc::FLOAT &&
           spec.format != OIIO::TypeDesc::DOUBLE && spec.get_string_attribute("oiio:ColorSpace", "sRGB") != "Linear";
}

/// Returns true if an OpenEXR file stores the pixels of a data window that differs from the display window, which is
/// the picture.
bool has_partial_data_window(const OIIO::ImageInput& input, const OIIO::ImageSpec& spec) {
    return input.format_name() == std::string("openexr") &&
           (spec.x != spec.full_x || spec.y != spec.full_y || spec.width != spec.full_width ||
            spec.height != spec.full_height);
}

/// Returns the message for an image whose channels are neither grey nor red, green and blue; empty if they are. Alpha
/// and further channels are permitted and ignored, but not the same colours in several layers.
std::string unexpected_channels(const OIIO::ImageSpec& spec) {
    const auto is_named = [&](int channel, const char* name) {
        const std::string& full = spec.channelnames[std::size_t(channel)];  // such as R or color.R
        return OIIO::Strutil::iequals(full.substr(full.rfind('.') + 1), name);
    };
    const bool is_grey = (spec.nchannels == 1 || (spec.nchannels == 2 && spec.alpha_channel == 1)) &&
                         spec.alpha_channel != 0 && spec.z_channel != 0,
               is_color = spec.nchannels >= 3 && is_named(0, "R") && is_named(1, "G") && is_named(2, "B");
    const std::string channels = "has the channels " + OIIO::Strutil::join(spec.channelnames, ", ");
    if (!is_grey && !is_color)
        return channels + "; it must have one channel of colour, or R, G and B, each with or without alpha";
    const bool is_in_layer = spec.channelnames[0].find('.') != std::string::npos;
    for (int channel = 3; is_in_layer && channel < spec.nchannels; ++channel)
        if (is_named(channel, "R")) return channels + "; store the layer to use in a file of its own";
    return {};
}

/// Returns the message for an image whose pixels are not stored as colours of an upright picture; empty if they are.
std::string unexpected_pixels(const OIIO::ImageSpec& spec) {
    if (spec.format == OIIO::TypeDesc::UINT32 || spec.format == OIIO::TypeDesc::INT32)
        return "has channels of 32-bit integers, which are no colours";
    constexpr int upright = 1;
    const int orientation = spec.get_int_attribute("Orientation", upright);
    if (orientation == upright) return {};
    return "is stored rotated or mirrored (orientation " + std::to_string(orientation) +
           " of Exif); store it upright, with the first row at the top";
}

/// Returns the message for an unreadable file. Not all readers of OpenImageIO state a reason.
std::string unreadable_message(const std::string& reason) {
    return "cannot be read as an image: " + (reason.empty() ? "it is truncated or damaged" : reason);
}

/// Returns the type in which components are read: the type of the file, if it is one of ComponentType.
ComponentType component_type(const OIIO::ImageSpec& spec, int channels) {
    if (spec.format == OIIO::TypeDesc::UINT8) return ComponentType::uint8;
    if (spec.format == OIIO::TypeDesc::UINT16) return ComponentType::uint16;
    for (int channel = 0; channel < channels; ++channel)
        if (spec.channelformat(channel) != OIIO::TypeDesc::HALF) return ComponentType::float32;
    return ComponentType::half;
}

OIIO::TypeDesc type_of(ComponentType type) {
    switch (type) {
        case ComponentType::uint8:
            return OIIO::TypeDesc::UINT8;
        case ComponentType::uint16:
            return OIIO::TypeDesc::UINT16;
        case ComponentType::half:
            return OIIO::TypeDesc::HALF;
        default:
            return OIIO::TypeDesc::FLOAT;
    }
}

/// Returns the number of rows that are read at once: whole blocks of the file, with about 16 MB.
int strip_height_of(const OIIO::ImageSpec& spec) {
    // Compressed OpenEXR files have blocks of up to 256 rows.
    const int block = spec.tile_height ? spec.tile_height : spec.get_int_attribute("tiff:RowsPerStrip", 256);
    const auto rows = static_cast<int>((1 << 24) / spec.scanline_bytes(true));
    return OIIO::round_to_multiple(std::clamp(rows, 1, spec.height), std::clamp(block, 1, spec.height));
}

/// Reads an image file with OpenImageIO.
class OpenImage final : public ImageFile {
public:
    /// The picture is the display window of OpenEXR files, and the stored pixels of other files.
    OpenImage(std::unique_ptr<OIIO::ImageInput> input, std::unique_ptr<OIIO::Filesystem::IOMemReader> memory)
        : memory_(std::move(memory)), input_(std::move(input)), spec_(input_->spec()) {
        is_partial_ = has_partial_data_window(*input_, spec_);
        width = is_partial_ ? spec_.full_width : spec_.width;
        height = is_partial_ ? spec_.full_height : spec_.height;
        channels = spec_.nchannels < 3 ? 1 : 3;
        type = component_type(spec_, channels);
        is_srgb = kagero::is_srgb(spec_);
        strip_height = strip_height_of(spec_);
    }
    std::string read(int begin, int end, void* components) override try {
        const bool done = is_partial_ ? read_window(begin, end, static_cast<char*>(components))
                                      : read_stored(spec_.y + begin, spec_.y + end, components);
        // Some readers report a truncated file only by an error message, without failing.
        return done && !input_->has_error() ? std::string() : unreadable_message(input_->geterror());
    } catch (const std::bad_alloc&) {
        return "requires more memory than is available";
    }
    std::vector<float> values_of_codes() const override {
        std::vector<std::uint16_t> words(1 << 16);
        std::iota(words.begin(), words.end(), std::uint16_t{0});
        const std::vector<std::uint8_t> bytes(words.begin(), words.begin() + 256);
        const bool is_byte = type == ComponentType::uint8;
        std::vector<float> values(is_byte ? bytes.size() : words.size());
        const void* codes = is_byte ? static_cast<const void*>(bytes.data()) : words.data();
        OIIO::convert_pixel_values(type_of(type), codes, OIIO::TypeDesc::FLOAT, values.data(), int(values.size()));
        return values;
    }

private:
    /// Reads stored rows. The numbers of the rows begin with that of the data window.
    bool read_stored(int begin, int end, void* components) {
        if (spec_.tile_width == 0)
            return input_->read_scanlines(0, 0, begin, end, 0, 0, channels, type_of(type), components);
        return input_->read_tiles(0, 0, spec_.x, spec_.x + spec_.width, begin, end, 0, 1, 0, channels, type_of(type),
                                  components);
    }
    /// Reads rows of the display window. Pixels outside the data window become black.
    bool read_window(int begin, int end, char* components) {
        const std::size_t pixel = type_of(type).size() * std::size_t(channels);
        std::memset(components, 0, pixel * std::size_t(width) * std::size_t(end - begin));
        const int left = std::max(spec_.x, spec_.full_x),
                  right = std::min(spec_.x + spec_.width, spec_.full_x + spec_.full_width),
                  top = std::max(spec_.y, spec_.full_y + begin),
                  bottom = std::min(spec_.y + spec_.height, spec_.full_y + end);
        if (left >= right || top >= bottom) return true;
        // Rows of tiles are read as a whole.
        const int block = std::max(1, spec_.tile_height), first = spec_.y + (top - spec_.y) / block * block,
                  last = std::min(spec_.y + OIIO::round_to_multiple(bottom - spec_.y, block), spec_.y + spec_.height);
        std::vector<char> stored(pixel * std::size_t(spec_.width) * std::size_t(last - first));
        if (!read_stored(first, last, stored.data())) return false;
        for (int y = top; y < bottom; ++y) {
            const std::size_t to = std::size_t(y - spec_.full_y - begin) * std::size_t(width) +
                                   std::size_t(left - spec_.full_x),
                              from = std::size_t(y - first) * std::size_t(spec_.width) + std::size_t(left - spec_.x);
            std::memcpy(components + pixel * to, &stored[pixel * from], pixel * std::size_t(right - left));
        }
        return true;
    }

    std::unique_ptr<OIIO::Filesystem::IOMemReader> memory_;  ///< Null for an image file; `input_` reads from it.
    std::unique_ptr<OIIO::ImageInput> input_;
    OIIO::ImageSpec spec_;
    bool is_partial_;
};

/// Returns the file extension of the format with whose signature the bytes of an image begin; "" if it is none of those
/// that other files contain.
std::string extension_of(const std::string& bytes) {
    return bytes.starts_with("\x89PNG") ? "png" : bytes.starts_with("\xff\xd8") ? "jpg" : "";
}

/// Opens an image file; implements Codec::open.
std::string open(const std::string& path, const std::string* bytes, std::unique_ptr<ImageFile>& file) try {
    // Alpha is ignored, so colours are requested as stored, not multiplied by alpha.
    OIIO::ImageSpec configuration;
    configuration.attribute("oiio:UnassociatedAlpha", 1);
    std::unique_ptr<OIIO::Filesystem::IOMemReader> memory;
    if (bytes) {
        memory = std::make_unique<OIIO::Filesystem::IOMemReader>(bytes->data(), bytes->size());
        OIIO::Filesystem::IOProxy* const proxy = memory.get();
        configuration.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    }
    auto input = OIIO::ImageInput::open(bytes ? "image." + extension_of(*bytes) : path, &configuration, memory.get());
    if (!input) return unreadable_message(OIIO::geterror());
    const OIIO::ImageSpec& spec = input->spec();
    if (spec.width <= 0 || spec.height <= 0 || spec.nchannels <= 0 || spec.depth > 1)
        return "is not a two-dimensional image with at least one pixel";
    if (std::string message = unexpected_channels(spec); !message.empty()) return message;
    if (std::string message = unexpected_pixels(spec); !message.empty()) return message;
    file = std::make_unique<OpenImage>(std::move(input), std::move(memory));
    return {};
} catch (const std::bad_alloc&) {
    return "requires more memory than is available, even before its size is read";
} catch (const std::length_error&) {
    return "requires more memory than is available, even before its size is read";
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

constexpr Codec image_module{codec_abi, open, encode, false_colors};

}  // namespace
}  // namespace kagero

extern "C" __attribute__((visibility("default"))) const kagero::Codec* kagero_codec() { return &kagero::image_module; }
