// Small pictures as PNG files in memory, for pages that hold them.
#include "film/image.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>

#include <algorithm>

namespace kagero {
namespace {

std::vector<unsigned char> png_of(const std::vector<unsigned char>& bytes, int width, int height) {
    std::vector<unsigned char> file;
    OIIO::Filesystem::IOVecOutput memory(file);
    const auto out = OIIO::ImageOutput::create("picture.png", &memory);
    if (!out || !out->open("picture.png", OIIO::ImageSpec(width, height, 3, OIIO::TypeDesc::UINT8)) ||
        !out->write_image(OIIO::TypeDesc::UINT8, bytes.data()) || !out->close())
        throw RunError("cannot make a PNG picture: " + (out ? out->geterror() : OIIO::geterror()));
    return file;
}

}  // namespace

std::vector<unsigned char> png_of_colors(const std::vector<float>& rgb, int width, int height) {
    std::vector<unsigned char> bytes(rgb.size());
    std::transform(rgb.begin(), rgb.end(), bytes.begin(), encode_srgb);
    return png_of(bytes, width, height);
}

std::vector<unsigned char> png_of_shares(const std::vector<float>& shares, int width, int height) {
    std::vector<float> plane = shares;
    for (float& share : plane) share = share >= 0 ? std::min(share, 1.0f) : 0.0f;
    const OIIO::ImageBuf gray(OIIO::ImageSpec(width, height, 1, OIIO::TypeDesc::FLOAT), plane.data());
    const OIIO::ImageBuf colored = OIIO::ImageBufAlgo::color_map(gray, 0, "inferno");
    std::vector<unsigned char> bytes;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            float color[3];
            colored.getpixel(x, y, color, 3);
            for (const float c : color)
                bytes.push_back(shares[std::size_t(y) * std::size_t(width) + std::size_t(x)] >= 0
                                    ? static_cast<unsigned char>(255 * std::clamp(c, 0.0f, 1.0f) + 0.5f)
                                    : 153);
        }
    return png_of(bytes, width, height);
}

}  // namespace kagero
