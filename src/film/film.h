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
    Scale scale;  ///< how it is mapped to false colours; colours are not, and HALF in EXR, all others FLOAT
    const char* what;

    bool half() const { return scale == Scale::colors; }
};
const std::vector<LayerInfo>& all_layers();

/// Where a film lies that is a part (crop) of a larger picture: its first pixel there, and how large that is. All 0: it
/// is the whole.
struct FilmPlace {
    std::uint32_t x = 0, y = 0, width = 0, height = 0;
};

/// Planes of the chosen layers for a window (crop) of the whole picture.
class Film {
public:
    Film(std::uint32_t width, std::uint32_t height, const std::vector<std::string>& layers,
         const FilmPlace& place = {});
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

}  // namespace kagero
