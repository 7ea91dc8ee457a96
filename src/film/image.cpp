#include "film/image.h"

#include "film/codec.h"

#include <array>
#include <cmath>

namespace kagero {

namespace {

float linear_from_srgb(float s) {
    return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

/// Linear values of the 256 sRGB values of images with eight bits per channel.
class SrgbTable {
public:
    SrgbTable() {
        for (std::size_t i = 0; i < linear_.size(); ++i) linear_[i] = linear_from_srgb(static_cast<float>(i) / 255);
    }
    /// Returns the linear value; values between those of the table are computed.
    float linear(float value) const {
        const float scaled = value * 255;
        if (!(scaled >= 0 && scaled <= 255)) return linear_from_srgb(value);
        const auto index = static_cast<std::size_t>(scaled + 0.5f);
        return std::abs(scaled - static_cast<float>(index)) < 1e-4f ? linear_[index] : linear_from_srgb(value);
    }

private:
    std::array<float, 256> linear_;
};

}  // namespace

Image read_image(const std::string& path, const FileLocation& location) {
    DecodedImage decoded;
    const std::string reason = codec().read(path, decoded);
    if (!reason.empty()) throw InputError(location, "\"" + path + "\" " + reason);
    const auto pixels = static_cast<std::size_t>(decoded.width) * static_cast<std::size_t>(decoded.height);
    const auto channels = static_cast<std::size_t>(decoded.channels);
    const SrgbTable table;
    for (std::size_t i = 0; i < channels * pixels; ++i) {
        float& value = decoded.values[i];
        if (!std::isfinite(value)) {
            const std::size_t pixel = i / channels, width = static_cast<std::size_t>(decoded.width);
            throw InputError(location, "\"" + path + "\" has a value that is not finite in pixel (" +
                                           std::to_string(pixel % width) + ", " + std::to_string(pixel / width) +
                                           "), counted from the upper left; correct the image");
        }
        if (decoded.srgb) value = table.linear(value);
    }
    // Large images are not copied.
    if (channels == 3) return {decoded.width, decoded.height, std::move(decoded.values)};
    Image image{decoded.width, decoded.height, std::vector<float>(3 * pixels)};
    for (std::size_t i = 0; i < 3 * pixels; ++i) image.rgb[i] = decoded.values[i / 3];
    return image;
}

unsigned char encode_srgb(float linear) {
    // The comparison is false if `linear` is NaN, so NaN becomes 0.
    const double x = linear > 0.0f ? std::min(static_cast<double>(linear), 1.0) : 0.0;
    const double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
    return static_cast<unsigned char>(std::lround(255.0 * encoded));
}

}  // namespace kagero
