#include "film/png.h"

#include "film/codec.h"
#include "film/image.h"

#include <algorithm>

namespace kagero {
namespace {

std::vector<unsigned char> png_of(const std::vector<unsigned char>& bytes, int width, int height) {
    std::vector<unsigned char> file;
    const std::string why =
        codec().encode(".png", {width, height, 3, PictureToEncode::Samples::bytes, bytes.data()}, file);
    if (!why.empty()) throw RunError("cannot make a PNG picture: " + why);
    return file;
}

}  // namespace

std::vector<unsigned char> png_of_colors(const std::vector<float>& rgb, int width, int height) {
    std::vector<unsigned char> bytes(rgb.size());
    std::transform(rgb.begin(), rgb.end(), bytes.begin(), encode_srgb);
    return png_of(bytes, width, height);
}

std::vector<unsigned char> png_of_shares(const std::vector<float>& shares, int width, int height) {
    return png_of(false_colored(shares), width, height);
}

std::vector<unsigned char> false_colored(const std::vector<float>& shares) {
    constexpr std::size_t at_once = 1 << 16;  // images count in int
    std::vector<unsigned char> bytes;
    bytes.reserve(3 * shares.size());
    std::vector<float> plane, rgb;
    for (std::size_t first = 0; first < shares.size(); first += at_once) {
        const std::size_t count = std::min(at_once, shares.size() - first);
        plane.assign(&shares[first], &shares[first] + count);
        for (float& share : plane) share = share >= 0 ? std::min(share, 1.0f) : 0.0f;
        const std::string why = codec().false_colors(plane, rgb);
        if (!why.empty()) throw RunError("cannot make false colours: " + why);
        for (std::size_t i = 0; i < rgb.size(); ++i)
            bytes.push_back(shares[first + i / 3] >= 0
                                ? static_cast<unsigned char>(255 * std::clamp(rgb[i], 0.0f, 1.0f) + 0.5f)
                                : 153);
    }
    return bytes;
}

}  // namespace kagero
