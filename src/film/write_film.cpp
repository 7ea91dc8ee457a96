#include "film/write_film.h"

#include "error.h"
#include "film/codec.h"
#include "film/partial_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <ostream>

namespace kagero {

namespace {

/// The content of a file: all layers, or only the layer `color`. Colours are encoded as 8-bit sRGB or as linear floats.
/// A portable float map and a NumPy array contain the floats of one layer.
enum class Encoding { layers, srgb8, linear, pfm, npy };

/// A picture format, which the extension of the file name selects.
struct Format {
    const char* extension;
    Encoding encoding;
    std::uint32_t max_edge = 0xffffffffu;  ///< Greatest width and height, pixels.
};

// All picture formats. A row may be added for any format that OpenImageIO writes.
constexpr Format formats[] = {
    {".exr", Encoding::layers},        {".png", Encoding::srgb8},        {".jpg", Encoding::srgb8, 65500},
    {".jpeg", Encoding::srgb8, 65500}, {".tif", Encoding::srgb8},        {".tiff", Encoding::srgb8},
    {".bmp", Encoding::srgb8},         {".tga", Encoding::srgb8, 65535}, {".ppm", Encoding::srgb8},
    {".webp", Encoding::srgb8, 16383}, {".pfm", Encoding::pfm},          {".hdr", Encoding::linear},
    {".npy", Encoding::npy},
};

// Value of the attribute DateTime. It replaces the current date, so that the same pixels give the same bytes.
constexpr const char* no_date = "";
constexpr float max_half = 65504.0f;  ///< Greatest finite value of HALF.

/// Returns the format for the extension of a path. Throws InputError if the extension is missing or not supported.
const Format& format_of(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    std::string lower = extension;
    for (char& c : lower)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    std::string extensions;
    for (const Format& format : formats) {
        if (lower == format.extension) return format;
        append_to_list(extensions, format.extension);
    }
    throw InputError("cannot write '" + path + "': " +
                     (extension.empty() ? "its name has no extension, which selects the picture format"
                                        : "'" + extension + "' is not a supported picture format") +
                     "; use one of the extensions " + extensions);
}

/// Returns true if files of this format contain the floats of one layer, which may be a layer of numbers.
bool stores_one_layer(const Format& format) {
    return format.encoding == Encoding::pfm || format.encoding == Encoding::npy;
}

/// Returns the name of the layer that a portable float map or a NumPy array contains. It is the only layer of a
/// picture; a portable float map of several layers contains `color`. Throws InputError if there is no such layer.
std::string single_layer(const std::string& path, const Format& format, const std::vector<std::string>& layers) {
    if (layers.size() == 1) return layers.front();
    const bool has_color = std::find(layers.begin(), layers.end(), "color") != layers.end();
    if (format.encoding == Encoding::pfm && has_color) return "color";
    std::string names;
    for (const std::string& layer : layers) append_to_list(names, layer);
    throw InputError("cannot write '" + path + "': " + format.extension + " stores one layer, and the picture has " +
                     std::to_string(layers.size()) + ": " + names +
                     "; select one with --layers (film.layers), or use .exr for all");
}

std::vector<std::string> names_of_layers(const Film& film) {
    std::vector<std::string> names;
    for (const LayerInfo* layer : film.layers()) names.push_back(layer->name);
    return names;
}

/// Returns the number of floats per pixel of a layer of the film.
std::size_t channels_of(const Film& film, const std::string& name) {
    const auto& layers = film.layers();
    return (*std::find_if(layers.begin(), layers.end(), [&](const LayerInfo* layer) { return layer->name == name; }))
        ->channels.size();
}

/// Returns the plane of the layer `color`. Throws RunError if the film does not have it.
const float* color_plane(const Film& film, const std::string& path) {
    const float* color = film.plane("color");
    if (!color) throw RunError("cannot write '" + path + "': this format stores only the layer 'color'");
    return color;
}

PictureToEncode picture_of(const Film& film, PictureToEncode::Samples samples, const void* pixels,
                           const char* color_space) {
    return {static_cast<int>(film.width()), static_cast<int>(film.height()), 3, samples, pixels,
            {{"oiio:ColorSpace", color_space}, {"DateTime", no_date}}};
}

/// Returns the channels of all layers, interleaved. `stride` is the number of channels of all layers.
std::vector<float> interleave(const Film& film, std::size_t stride) {
    const std::size_t pixels = std::size_t{film.width()} * film.height();
    std::vector<float> interleaved(pixels * stride);
    std::size_t first_channel = 0;
    for (const LayerInfo* layer : film.layers()) {
        const float* plane = film.plane(layer->name);
        const std::size_t channels = layer->channels.size();
        for (std::size_t i = 0; i < pixels; ++i)
            for (std::size_t c = 0; c < channels; ++c) {
                const float value = plane[i * channels + c];
                // Values beyond the range of HALF would become infinite, and viewers do not show infinity as bright.
                // std::clamp returns NaN for NaN.
                interleaved[i * stride + first_channel + c] =
                    layer->half() ? std::clamp(value, -max_half, max_half) : value;
            }
        first_channel += channels;
    }
    return interleaved;
}

/// Calls use(PictureToEncode) with the picture of all layers.
template <class Use>
void with_layers(const Film& film, const Metadata& metadata, const Use& use) {
    PictureToEncode picture = picture_of(film, PictureToEncode::Samples::floats, nullptr, "Linear");
    for (const LayerInfo* layer : film.layers())
        for (const std::string& channel : layer->channels) {
            picture.names.push_back(layer->name + "." + channel);
            picture.half.push_back(layer->half());
        }
    picture.channels = static_cast<int>(picture.names.size());
    const CropWindow& window = film.window();
    picture.x = static_cast<int>(window.x);
    picture.y = static_cast<int>(window.y);
    picture.whole_width = static_cast<int>(window.width);
    picture.whole_height = static_cast<int>(window.height);
    picture.attributes.emplace_back("compression", "zip");
    for (const auto& [name, value] : metadata) picture.attributes.emplace_back("kagero/" + name, value);
    const std::vector<float> pixels = interleave(film, picture.names.size());
    picture.pixels = pixels.data();
    use(picture);
}

/// Calls use(PictureToEncode) with the colours in 8 bits.
template <class Use>
void with_srgb8(const Film& film, const std::string& path, const Use& use) {
    const float* color = color_plane(film, path);
    const std::vector<unsigned char> bytes =
        display_bytes(color, std::size_t{film.width()} * film.height() * 3, film.tone());
    PictureToEncode picture = picture_of(film, PictureToEncode::Samples::bytes, bytes.data(), "sRGB");
    picture.quality = 95;
    picture.attributes.emplace_back("jpeg:subsampling", "4:4:4");
    use(picture);
}

static_assert(std::endian::native == std::endian::little, "the files contain little-endian floats");

void write_floats(std::ostream& out, const float* first, std::size_t count) {
    out.write(reinterpret_cast<const char*>(first), static_cast<std::streamsize>(count * sizeof(float)));
}

/// Writes a portable float map, which OpenImageIO 2.4 reads but does not write: one or three floats per pixel, rows
/// from the bottom.
void write_pfm(const Film& film, const std::string& path) {
    const std::string layer = single_layer(path, format_of(path), names_of_layers(film));
    const std::size_t row = std::size_t{film.width()} * channels_of(film, layer);
    const float* plane = film.plane(layer);
    write_file(path, [&](std::ostream& out) {
        // The -1 means little-endian. Without std::to_string, the numbers would depend on the stream's locale.
        out << (row == film.width() ? "Pf\n" : "PF\n") + std::to_string(film.width()) + ' ' +
                   std::to_string(film.height()) + "\n-1.0\n";
        for (std::size_t y = film.height(); y-- > 0;) write_floats(out, plane + y * row, row);
    });
}

/// Writes an array of NumPy (format version 1.0) with the shape (height, width) or (height, width, 3).
void write_npy(const Film& film, const std::string& path) {
    const std::string layer = single_layer(path, format_of(path), names_of_layers(film));
    const std::size_t channels = channels_of(film, layer);
    std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + std::to_string(film.height()) + ", " +
                         std::to_string(film.width()) + (channels > 1 ? ", " + std::to_string(channels) : "") + "), }";
    constexpr std::size_t alignment = 64, preamble = 10;  // bytes
    header.append(alignment - 1 - (preamble + header.size()) % alignment, ' ');
    header += '\n';
    write_file(path, [&](std::ostream& out) {
        const char size[2] = {static_cast<char>(header.size() & 0xff), static_cast<char>(header.size() >> 8)};
        out.write("\x93NUMPY\x01\x00", 8).write(size, 2) << header;
        write_floats(out, film.plane(layer), std::size_t{film.width()} * film.height() * channels);
    });
}

}  // namespace

bool stores_all_layers(const std::string& path) {
    return format_of(path).encoding == Encoding::layers;
}

void check_writable(const std::string& path, const std::vector<std::string>& layers, std::uint32_t width,
                    std::uint32_t height) {
    check_file_writable(path);
    const Format& format = format_of(path);
    if (stores_one_layer(format)) single_layer(path, format, layers);
    else if (format.encoding != Encoding::layers && std::find(layers.begin(), layers.end(), "color") == layers.end())
        throw InputError("cannot write '" + path +
                         "': only .exr, .npy and .pfm can store a picture without the layer 'color'; add it to "
                         "film.layers");
    if (std::max(width, height) > format.max_edge)
        throw InputError("cannot write '" + path + "': the picture has " + std::to_string(width) + " x " +
                         std::to_string(height) + " pixels, and " + format.extension + " allows at most " +
                         std::to_string(format.max_edge) + " along an edge; use .exr");
}

void prepare_to_write(const std::string& path) {
    if (const Format& format = format_of(path); !stores_one_layer(format)) load_encoder(format.extension);
}

std::vector<unsigned char> encode_film(const Film& film, const std::string& extension, const Metadata& metadata) {
    const std::string name = "picture" + extension;
    std::vector<unsigned char> file;
    std::string reason = "this format is only written to files";
    const auto encode = [&](const PictureToEncode& picture) { reason = encode_picture(extension, picture, file); };
    const Encoding encoding = format_of(name).encoding;
    if (encoding == Encoding::layers) with_layers(film, metadata, encode);
    if (encoding == Encoding::srgb8) with_srgb8(film, name, encode);
    if (!reason.empty()) throw RunError("encoding a picture as " + extension + " failed: " + reason);
    return file;
}

void write_film(const Film& film, const std::string& path, const Metadata& metadata) {
    const auto write = [&](const PictureToEncode& picture) { write_picture(path, picture); };
    switch (format_of(path).encoding) {
        case Encoding::layers: return with_layers(film, metadata, write);
        case Encoding::srgb8: return with_srgb8(film, path, write);
        case Encoding::pfm:
            return write_pfm(film, path);
        case Encoding::npy: return write_npy(film, path);
        case Encoding::linear: {
            const float* color = color_plane(film, path);
            std::vector<float> clamped(color, color + std::size_t{film.width()} * film.height() * 3);
            for (float& channel : clamped) channel = std::max(channel, 0.0f);  // the shared-exponent format has no sign
            return write_picture(path, picture_of(film, PictureToEncode::Samples::floats, clamped.data(), "Linear"));
        }
    }
}

}  // namespace kagero
