/// The interface of the image module (film/openimageio/module.cpp), which reads and writes image files with
/// OpenImageIO. It is a separate shared library, because loading OpenImageIO takes longer than rendering a small
/// picture, and many commands do not need it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace kagero {

/// A decoded image: floats with one or three channels, row by row from the top.
struct DecodedImage {
    int width = 0, height = 0, channels = 0;
    bool srgb = false;  ///< True for sRGB-encoded values; false for linear values.
    std::vector<float> values;
};

/// A picture to encode. Pixels are stored row by row from the top, with interleaved channels.
struct PictureToEncode {
    enum class Samples { bytes, floats };

    int width, height, channels;
    Samples samples;
    const void* pixels;
    std::vector<std::pair<std::string, std::string>> attributes{};
    std::vector<std::string> names{};  ///< Names of the channels; empty: R, G, B.
    std::vector<bool> half{};          ///< True for each named channel that is stored as a 16-bit float.
    int x = 0, y = 0;                  ///< Position of the first pixel of a crop in the whole picture.
    int whole_width = 0, whole_height = 0;  ///< Size of the whole picture; 0: this picture is not a crop.
    int quality = 0;                   ///< Quality of lossy compression, percent; 0: default of the format.
};

/// The functions of the image module. Each returns "" on success, otherwise the reason for the failure.
struct Codec {
    std::uint32_t abi;  ///< The value of codec_abi with which the module was compiled.
    /// Reads an image file.
    std::string (*read)(const std::string& path, DecodedImage& image);
    /// Encodes a picture as the bytes of a file with this extension, such as ".png".
    std::string (*encode)(const std::string& extension, const PictureToEncode& picture,
                          std::vector<unsigned char>& file);
    /// Maps numbers in [0, 1] to false colours from dark to bright, with three floats per number.
    std::string (*false_colors)(const std::vector<float>& numbers, std::vector<float>& rgb);
};

/// Version of this interface. It changes with every change of the types in this file.
inline constexpr std::uint32_t codec_abi = 3;
/// Type of the function `kagero_codec`, which the module exports.
using CodecFunction = const Codec* (*)();

/// Returns the functions of the image module; the first call loads it. Throws RunError if the module is missing or
/// belongs to another version.
const Codec& codec();
/// Writes a picture to a file, in the format that the extension of `path` selects. Throws RunError if encoding or
/// writing fails.
void write_picture(const std::string& path, const PictureToEncode& picture);

}  // namespace kagero
