/// Image files. OpenImageIO reads and writes them, in a module of its own (openimageio/module.cpp): with the libraries
/// it brings it takes longer to load than a small picture to render, and many verbs never need it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace kagero {

/// What a file holds: one channel or three, as floats row by row from the top.
struct DecodedImage {
    int width = 0, height = 0, channels = 0;
    bool srgb = false;  ///< encoded so; linear otherwise
    std::vector<float> values;
};

/// A picture to be written; pixels row by row from the top, channels interleaved.
struct PictureToEncode {
    enum class Samples { bytes, floats };

    int width, height, channels;
    Samples samples;
    const void* pixels;
    std::vector<std::pair<std::string, std::string>> attributes{};
    std::vector<std::string> names{};  ///< of the channels; empty: red, green and blue
    std::vector<bool> half{};          ///< which of the named channels are stored as 16-bit floats
    int x = 0, y = 0, whole_width = 0,
        whole_height = 0;              ///< where it lies in a larger picture, and the size of that; 0: it is the whole
    int quality = 0;                   ///< percent, of what compresses with a loss; 0: as the format has it
};

/// What the module offers. Each call returns why it failed, in words, or nothing.
struct Codec {
    std::uint32_t abi;
    std::string (*read)(const std::string& path, DecodedImage& image);
    /// The bytes of a file with this extension (".png").
    std::string (*encode)(const std::string& extension, const PictureToEncode& picture,
                          std::vector<unsigned char>& file);
    /// Shares in [0, 1] from dark to bright, as linear RGB.
    std::string (*false_colors)(const std::vector<float>& shares, std::vector<float>& rgb);
};

inline constexpr std::uint32_t codec_abi = 3;
using KageroCodec = const Codec* (*)();

/// Loads the module when it is first asked for. Throws RunError where it is missing.
const Codec& codec();
/// Writes a picture in the format that the extension of `path` says. Throws RunError.
void write_picture(const std::string& path, const PictureToEncode& picture);

}  // namespace kagero
