#include "film/png.h"

#include "error.h"
#include "film/codec.h"

#include <algorithm>

namespace kagero {
namespace {

/// Returns the PNG file of a picture of RGB bytes.
std::vector<unsigned char> png_of(const std::vector<unsigned char>& bytes, int width, int height) {
    std::vector<unsigned char> file;
    const std::string reason =
        encode_picture(".png", {width, height, 3, PictureToEncode::Samples::bytes, bytes.data()}, file);
    if (!reason.empty()) throw RunError("encoding a PNG picture failed: " + reason);
    return file;
}

}  // namespace

std::vector<unsigned char> png_of_colors(const std::vector<float>& rgb, int width, int height, const Tone& tone) {
    return png_of(display_bytes(rgb.data(), rgb.size(), tone), width, height);
}

std::vector<unsigned char> png_of_false_colors(const std::vector<float>& positions, int width, int height) {
    return png_of(false_colored(positions), width, height);
}

std::vector<unsigned char> false_colored(const std::vector<float>& positions) {
    constexpr std::size_t block_size = 1 << 16;  // pixels per call of OpenImageIO, which counts pixels with int
    constexpr unsigned char grey = 153;
    std::vector<unsigned char> bytes;
    bytes.reserve(3 * positions.size());
    std::vector<float> plane, rgb;
    for (std::size_t begin = 0; begin < positions.size(); begin += block_size) {
        const std::size_t count = std::min(block_size, positions.size() - begin);
        plane.assign(&positions[begin], &positions[begin] + count);
        for (float& position : plane) position = position >= 0 ? std::min(position, 1.0f) : 0.0f;
        const std::string reason = codec().false_colors(plane, rgb);
        if (!reason.empty()) throw RunError("mapping to false colours failed: " + reason);
        for (std::size_t i = 0; i < rgb.size(); ++i)
            bytes.push_back(positions[begin + i / 3] >= 0
                                ? static_cast<unsigned char>(255 * std::clamp(rgb[i], 0.0f, 1.0f) + 0.5f)
                                : grey);
    }
    return bytes;
}

}  // namespace kagero
