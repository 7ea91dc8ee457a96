/// Images in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <variant>
#include <vector>

namespace kagero {

/// An image: linear RGB, three floats per pixel, row by row from the top.
struct Image {
    int width = 0, height = 0;
    std::vector<float> rgb;
};

/// Components of pixels that are stored as codes of 8 or 16 bits.
template <class Code>
struct CodedComponents {
    std::vector<Code> codes;
    std::vector<float> linear;  ///< The linear value of each code: 256 or 65536 values.
};

/// An image in the precision of its file: RGB, row by row from the top. Integers, and the bits of 16-bit floats, are
/// codes. Other components are linear floats.
struct StoredImage {
    int width = 0, height = 0;
    std::variant<std::vector<float>, CodedComponents<std::uint8_t>, CodedComponents<std::uint16_t>> rgb;
};

/// Access to the linear values of an image whose components are stored as codes, or as floats.
template <class Stored>
struct Texels {
    int width, height;
    const Stored* stored;
    const float* linear;  ///< The linear value of each code; not used for floats.

    /// Returns the linear value of a component. The components of pixel (x, y) begin at 3 (y width + x).
    float operator[](std::size_t i) const {
        if constexpr (std::is_same_v<Stored, float>) return stored[i];
        else return linear[stored[i]];
    }
};

inline Texels<float> texels_of(const Image& image) {
    return {image.width, image.height, image.rgb.data(), nullptr};
}

/// Calls visit(Texels<T>) with the type T of the image's components, so that `visit` is compiled for each type.
template <class Visit>
decltype(auto) visit_texels(const StoredImage& image, const Visit& visit) {
    if (const auto* floats = std::get_if<0>(&image.rgb))
        return visit(Texels<float>{image.width, image.height, floats->data(), nullptr});
    if (const auto* bytes = std::get_if<1>(&image.rgb))
        return visit(Texels<std::uint8_t>{image.width, image.height, bytes->codes.data(), bytes->linear.data()});
    const auto& words = std::get<2>(image.rgb);
    return visit(Texels<std::uint16_t>{image.width, image.height, words.codes.data(), words.linear.data()});
}

/// Encodes one linear colour component as sRGB. NaN becomes 0.
unsigned char encode_srgb(float linear);

}  // namespace kagero
