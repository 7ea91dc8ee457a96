/// The picture being made: one plane of floats per channel, and its way to disk.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace kagero {

/// One output layer; a new one is one row of the table in film.cpp.
struct LayerInfo {
    enum class Scale { colors, linear, logarithmic };

    std::string name;
    std::vector<std::string> channels;  ///< "R","G","B" or one channel
    Scale scale;                        ///< how it is mapped to false colours; colours are not, and HALF in EXR, all others FLOAT
    const char* what;

    bool half() const { return scale == Scale::colors; }
};
const std::vector<LayerInfo>& all_layers();

/// Where a film lies that is a part (crop) of a larger picture: its first pixel there, and how large that is. All 0: it is the whole.
struct FilmPlace {
    std::uint32_t x = 0, y = 0, width = 0, height = 0;
};

/// Planes of the chosen layers for a window (crop) of the whole picture.
class Film {
public:
    Film(std::uint32_t width, std::uint32_t height, const std::vector<std::string>& layers, const FilmPlace& place = {});
    std::uint32_t width() const { return width_; }
    std::uint32_t height() const { return height_; }
    const FilmPlace& place() const { return place_; }
    const std::vector<const LayerInfo*>& layers() const { return layers_; }
    bool has(const std::string& layer) const;
    /// First float of pixel (x, y) of a layer; its channels follow each other. Layer must be present.
    float* pixel(const std::string& layer, std::uint32_t x, std::uint32_t y);
    /// All floats of a layer, row by row, channels interleaved; null when absent.
    float* plane(const std::string& layer);
    const float* plane(const std::string& layer) const;

private:
    std::uint32_t width_, height_;
    FilmPlace place_;
    std::vector<const LayerInfo*> layers_;
    std::vector<std::vector<float>> planes_;
};

/// Name and value of one `kagero/*` attribute of the written file.
using Metadata = std::vector<std::pair<std::string, std::string>>;

/// Whether a picture of this name holds every layer, and metadata. Throws InputError when its extension is that of no picture.
bool holds_layers(const std::string& path);
/// Throws InputError when `path` has no extension that can be written, no file can be put there, or the format cannot hold so many pixels or
/// the layers: those without layers need `color`. Called before rendering.
void check_writable(const std::string& path, const std::vector<std::string>& layers, std::uint32_t width, std::uint32_t height);

/// Loads what write_film will need, which takes a moment that others may use. Throws RunError.
void prepare_to_write(const std::string& path);

/// Writes `.exr` with all layers (`layer.channel`), its place in the whole picture and metadata, other formats with the color layer alone (8-bit formats
/// sRGB-encoded). The file appears under its name only when it is complete. Throws RunError.
void write_film(const Film& film, const std::string& path, const Metadata& metadata);

}  // namespace kagero
