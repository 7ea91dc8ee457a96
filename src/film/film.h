/// The picture in memory: one plane of floats per layer.
#pragma once

#include "film/tone.h"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace kagero {

/// An output layer. A new layer requires one row of the table in film.cpp.
struct LayerInfo {
    enum class Scale { colors, linear, logarithmic };
    /// The value of a pixel with several rays: that of the first ray, or the mean or greatest value of all.
    enum class OfRays { mean, first, greatest };

    std::string name;
    std::vector<std::string> channels;  ///< Names of the channels: "R", "G", "B", or "V".
    Scale scale;       ///< Scale of the false-colour map of the layer; a layer of colours has no map.
    const char* what;  ///< Description in one line.
    OfRays of_rays = OfRays::mean;
    /// True if the layer can be computed from interpolated ray ends (film.sampling = "adaptive").
    bool interpolates = true;

    /// Returns true if the layer is stored as HALF in EXR files; other layers are stored as FLOAT.
    bool half() const { return scale == Scale::colors; }
};
/// Returns all layers.
const std::vector<LayerInfo>& all_layers();

/// The position of a crop in the whole picture. All numbers are 0 if the film is not a crop.
struct CropWindow {
    std::uint32_t x = 0, y = 0;           ///< Position of the first pixel of the crop.
    std::uint32_t width = 0, height = 0;  ///< Size of the whole picture.
};

/// Whether a film has memory for its pixels. A film without planes describes a picture whose pixels are kept elsewhere.
enum class Planes { allocated, none };

/// The planes of the selected layers, for a picture or a crop of it.
class Film {
public:
    /// Allocates the planes. Throws InputError if there is no layer with one of the names in `layers`.
    Film(std::uint32_t width, std::uint32_t height, const std::vector<std::string>& layers,
         const CropWindow& window = {}, const Tone& tone = {}, Planes planes = Planes::allocated);
    std::uint32_t width() const { return width_; }
    std::uint32_t height() const { return height_; }
    const CropWindow& window() const { return window_; }
    /// Returns the conversion of the colours for displays. It does not change the planes.
    const Tone& tone() const { return tone_; }
    void set_tone(const Tone& tone) { tone_ = tone; }
    const std::vector<const LayerInfo*>& layers() const { return layers_; }
    /// Returns true if the layer was selected.
    bool has(const std::string& layer) const;
    /// Returns the first float of pixel (x, y) of a layer; the channels of the pixel are consecutive. The film must
    /// have the layer.
    float* pixel(const std::string& layer, std::uint32_t x, std::uint32_t y);
    /// Returns all floats of a layer, row by row with interleaved channels, or nullptr if the film does not have the
    /// layer, or no planes.
    float* plane(const std::string& layer);
    const float* plane(const std::string& layer) const;
    /// Moves the floats of a layer, which the film must have, out of the film. Afterwards, the layer is empty.
    std::vector<float> take_plane(const std::string& layer);

private:
    std::uint32_t width_, height_;
    CropWindow window_;
    Tone tone_;
    std::vector<const LayerInfo*> layers_;
    std::vector<std::vector<float>> planes_;
};

}  // namespace kagero
