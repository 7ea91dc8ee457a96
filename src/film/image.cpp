#include "film/image.h"

#include "film/codec.h"

#include <cmath>

namespace kagero {

namespace {

float linear_from_srgb(float s) {
    return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

}  // namespace

Image read_image(const std::string& path, const FileLocation& location) {
    DecodedImage decoded;
    const std::string reason = codec().read(path, decoded);
    if (!reason.empty()) throw InputError(location, "\"" + path + "\" " + reason);
    const auto pixels = static_cast<std::size_t>(decoded.width) * static_cast<std::size_t>(decoded.height);
    Image image{decoded.width, decoded.height, std::vector<float>(3 * pixels)};
    for (std::size_t i = 0; i < pixels; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            const float value = decoded.values[decoded.channels == 1 ? i : 3 * i + c];
            if (!std::isfinite(value))
                throw InputError(location, "\"" + path + "\" has a pixel value that is not finite; correct the image");
            image.rgb[3 * i + c] = decoded.srgb ? linear_from_srgb(value) : value;
        }
    }
    return image;
}

unsigned char encode_srgb(float linear) {
    // The comparison is false if `linear` is NaN, so NaN becomes 0.
    const double x = linear > 0.0f ? std::min(static_cast<double>(linear), 1.0) : 0.0;
    const double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
    return static_cast<unsigned char>(std::lround(255.0 * encoded));
}

}  // namespace kagero
