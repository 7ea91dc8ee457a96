/// The interfaces of the modules that read and write image files. They are separate shared libraries, which are loaded
/// when they are needed: loading OpenImageIO takes longer than rendering a small picture. The image module
/// (film/openimageio/module.cpp) reads and writes all formats with OpenImageIO. The encoders (film/openexr/module.cpp,
/// film/libpng/module.cpp) write the most frequent formats without it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace kagero {

/// Types of the components of a decoded image. Files with components of other types are converted to `float32`.
enum class ComponentType { uint8, uint16, half, float32 };

/// An image file that is being read. The module implements it for the formats of OpenImageIO.
class ImageFile {
public:
    virtual ~ImageFile() = default;
    int width = 0, height = 0;
    int channels = 0;      ///< 1 for grey, or 3 for red, green and blue.
    ComponentType type = ComponentType::float32;
    bool is_srgb = false;  ///< True for sRGB-encoded values; false for linear values.
    int strip_height = 0;  ///< Number of rows per call of `read` for which the reader of the format is fast.

    /// Reads the rows from `begin` to `end` − 1, counted from the top, without changes to the type of the components.
    /// `begin` is a multiple of `strip_height`, and `end` is the next one, or the height. Returns "" on success,
    /// otherwise the reason for the failure.
    virtual std::string read(int begin, int end, void* components) = 0;
    /// Returns the values of all 256 or 65536 components of a type with 8 or 16 bits. Integers are divided by the
    /// greatest integer of their type.
    virtual std::vector<float> values_of_codes() const = 0;
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
    /// Opens an image file for reading. If `bytes` is not null, it is the content of the file, which must outlive
    /// `file`; `path` is then its name.
    std::string (*open)(const std::string& path, const std::string* bytes, std::unique_ptr<ImageFile>& file);
    /// Encodes a picture as the bytes of a file with this extension, such as ".png".
    std::string (*encode)(const std::string& extension, const PictureToEncode& picture,
                          std::vector<unsigned char>& file);
    /// Maps numbers in [0, 1] to false colours from dark to bright, with three floats per number.
    std::string (*false_colors)(const std::vector<float>& numbers, std::vector<float>& rgb);
};

/// The function of a module that encodes one format; see Codec::encode.
struct Encoder {
    std::uint32_t abi;  ///< The value of codec_abi with which the module was compiled.
    std::string (*encode)(const std::string& extension, const PictureToEncode& picture,
                          std::vector<unsigned char>& file);
};

/// Version of these interfaces. It changes with every change of the types in this file.
inline constexpr std::uint32_t codec_abi = 6;
/// Type of the function `kagero_codec`, which the image module exports.
using CodecFunction = const Codec* (*)();
/// Type of the function `kagero_encoder`, which the other modules export.
using EncoderFunction = const Encoder* (*)();

/// Returns the functions of the image module; the first call loads it. Throws RunError if the module is missing or
/// belongs to another version.
const Codec& codec();
/// Loads the module that encodes pictures in the format with this extension: its own encoder, or the image module if
/// there is none. Throws RunError if no module is found, or it belongs to another version.
void load_encoder(const std::string& extension);
/// Encodes a picture as the bytes of a file with this extension, such as ".png". Returns "" on success, otherwise the
/// reason for the failure. Throws RunError as load_encoder does.
std::string encode_picture(const std::string& extension, const PictureToEncode& picture,
                           std::vector<unsigned char>& file);
/// Writes a picture to a file, in the format that the extension of `path` selects. Throws RunError if encoding or
/// writing fails.
void write_picture(const std::string& path, const PictureToEncode& picture);

}  // namespace kagero
