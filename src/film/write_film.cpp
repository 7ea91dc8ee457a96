// A film's way to disk: EXR with every layer, or a picture of the colours alone.
#include "film/film.h"

#include "error.h"
#include "film/image.h"
#include "film/partial_file.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>

namespace kagero {

namespace {

enum class Encoding { layers, srgb8, linear, pfm };

struct Format {
    const char* extension;
    Encoding encoding;
};

// One row is one more file format (of those OpenImageIO writes).
constexpr Format formats[] = {
    {".exr", Encoding::layers}, {".png", Encoding::srgb8},  {".jpg", Encoding::srgb8}, {".jpeg", Encoding::srgb8},
    {".tif", Encoding::srgb8},  {".tiff", Encoding::srgb8}, {".bmp", Encoding::srgb8}, {".tga", Encoding::srgb8},
    {".ppm", Encoding::srgb8},  {".webp", Encoding::srgb8}, {".pfm", Encoding::pfm},   {".hdr", Encoding::linear},
};

// OpenImageIO would write the time of day; the same pixels give the same bytes.
constexpr const char* fixed_date = "";
constexpr float greatest_half = 65504.0f;

Encoding encoding_of(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    std::string lower = extension;
    for (char& c : lower)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    std::string known;
    for (const Format& format : formats) {
        if (lower == format.extension) return format.encoding;
        known += std::string(known.empty() ? "" : ", ") + format.extension;
    }
    throw InputError("cannot write '" + path + "': " +
                     (extension.empty() ? "its name has no extension that says which kind of picture it is"
                                        : "'" + extension + "' is not a kind of picture that can be written") +
                     "; use one of " + known);
}

const float* color_plane(const Film& film, const std::string& path) {
    const float* color = film.plane("color");
    if (!color) throw RunError("cannot write '" + path + "': only .exr can hold a picture without the layer 'color'");
    return color;
}

}  // namespace

unsigned char encode_srgb(float linear) {
    // Comparisons are false on NaN, which becomes black.
    const double x = linear > 0.0f ? std::min(static_cast<double>(linear), 1.0) : 0.0;
    const double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
    return static_cast<unsigned char>(std::lround(255.0 * encoded));
}

namespace {

void write_pixels(const OIIO::ImageSpec& spec, const std::string& path, OIIO::TypeDesc type, const void* pixels) {
    PartialFile file(path);
    const auto out = OIIO::ImageOutput::create(file.temporary());
    if (!out) throw RunError("cannot write '" + path + "': " + OIIO::geterror());
    const bool opened = out->open(file.temporary(), spec);
    const bool done = opened && out->write_image(type, pixels);
    if (!done || !out->close()) throw RunError("cannot write '" + path + "': " + out->geterror());
    file.complete();
}

/// Channels of all layers, interleaved, in the order of `spec`.
std::vector<float> interleave(const Film& film, const OIIO::ImageSpec& spec) {
    const std::size_t pixels = std::size_t{film.width()} * film.height();
    const std::size_t stride = static_cast<std::size_t>(spec.nchannels);
    std::vector<float> all(pixels * stride);
    std::size_t first = 0;
    for (const LayerInfo* layer : film.layers()) {
        const float* plane = film.plane(layer->name);
        const std::size_t channels = layer->channels.size();
        for (std::size_t i = 0; i < pixels; ++i)
            for (std::size_t c = 0; c < channels; ++c) {
                const float value = plane[i * channels + c];
                // Beyond the range of HALF lies infinity, which no viewer shows as bright. NaN stays NaN.
                all[i * stride + first + c] = layer->half() ? std::clamp(value, -greatest_half, greatest_half) : value;
            }
        first += channels;
    }
    return all;
}

void write_layers(const Film& film, const std::string& path, const Metadata& metadata) {
    std::vector<std::string> names;
    std::vector<OIIO::TypeDesc> types;
    for (const LayerInfo* layer : film.layers())
        for (const std::string& channel : layer->channels) {
            names.push_back(layer->name + "." + channel);
            types.push_back(layer->half() ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT);
        }
    const int width = static_cast<int>(film.width()), height = static_cast<int>(film.height());
    OIIO::ImageSpec spec(width, height, static_cast<int>(names.size()), OIIO::TypeDesc::FLOAT);
    spec.channelnames = names;
    spec.channelformats = types;
    spec.attribute("compression", "zip");
    spec.attribute("oiio:ColorSpace", "Linear");
    spec.attribute("DateTime", fixed_date);
    for (const auto& [name, value] : metadata) spec.attribute("kagero/" + name, value);
    write_pixels(spec, path, OIIO::TypeDesc::FLOAT, interleave(film, spec).data());
}

OIIO::ImageSpec color_spec(const Film& film, OIIO::TypeDesc type, const char* color_space) {
    OIIO::ImageSpec spec(static_cast<int>(film.width()), static_cast<int>(film.height()), 3, type);
    spec.attribute("oiio:ColorSpace", color_space);
    spec.attribute("DateTime", fixed_date);
    return spec;
}

void write_srgb8(const Film& film, const std::string& path) {
    const float* color = color_plane(film, path);
    std::vector<unsigned char> bytes(std::size_t{film.width()} * film.height() * 3);
    std::transform(color, color + bytes.size(), bytes.begin(), encode_srgb);
    OIIO::ImageSpec spec = color_spec(film, OIIO::TypeDesc::UINT8, "sRGB");
    spec.attribute("CompressionQuality", 95);
    spec.attribute("jpeg:subsampling", "4:4:4");
    write_pixels(spec, path, OIIO::TypeDesc::UINT8, bytes.data());
}

/// Portable float map, which OpenImageIO 2.4 reads but does not write: three floats per pixel, rows from the bottom.
void write_pfm(const Film& film, const std::string& path) {
    static_assert(std::endian::native == std::endian::little, "the -1 in the header says little-endian");
    const float* color = color_plane(film, path);
    const std::size_t row = std::size_t{film.width()} * 3;
    PartialFile file(path);
    std::ofstream out(file.temporary(), std::ios::binary);
    out << "PF\n" << film.width() << ' ' << film.height() << "\n-1.0\n";
    for (std::size_t y = film.height(); y-- > 0;)
        out.write(reinterpret_cast<const char*>(color + y * row), static_cast<std::streamsize>(row * sizeof(float)));
    out.close();
    if (!out) throw RunError("cannot write '" + path + "': is the disk full?");
    file.complete();
}

}  // namespace

void check_writable(const std::string& path) {
    check_file_writable(path);
    encoding_of(path);
}

void check_writable(const std::string& path, const std::vector<std::string>& layers) {
    check_writable(path);
    if (encoding_of(path) != Encoding::layers && std::find(layers.begin(), layers.end(), "color") == layers.end())
        throw InputError("cannot write '" + path +
                         "': only .exr can hold a picture without the layer 'color'; add it to film.layers");
}

void write_film(const Film& film, const std::string& path, const Metadata& metadata) {
    switch (encoding_of(path)) {
        case Encoding::layers:
            return write_layers(film, path, metadata);
        case Encoding::srgb8:
            return write_srgb8(film, path);
        case Encoding::pfm:
            return write_pfm(film, path);
        case Encoding::linear:
            return write_pixels(color_spec(film, OIIO::TypeDesc::FLOAT, "Linear"), path, OIIO::TypeDesc::FLOAT,
                                color_plane(film, path));
    }
}

}  // namespace kagero
