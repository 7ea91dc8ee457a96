#include "film/image.h"

#include <OpenImageIO/imageio.h>

#include <cmath>
#include <limits>
#include <memory>

namespace kagero {

namespace {

float linear_from_srgb(float s) {
    return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

/// Integer images hold sRGB unless they say otherwise; floating-point ones are linear.
bool is_srgb(const OIIO::ImageSpec& spec) {
    return spec.format != OIIO::TypeDesc::HALF && spec.format != OIIO::TypeDesc::FLOAT && spec.format != OIIO::TypeDesc::DOUBLE &&
           spec.get_string_attribute("oiio:ColorSpace", "sRGB") != "Linear";
}

}  // namespace

Image read_image(const std::string& path, const Place& place) {
    // Alpha is dropped, so colours are wanted as stored and not multiplied by it.
    OIIO::ImageSpec wish;
    wish.attribute("oiio:UnassociatedAlpha", 1);
    const auto input = OIIO::ImageInput::open(path, &wish);
    if (!input) throw InputError(place, "\"" + path + "\" cannot be read as an image: " + OIIO::geterror());
    const OIIO::ImageSpec spec = input->spec();
    if (spec.width <= 0 || spec.height <= 0 || spec.nchannels <= 0 || spec.depth > 1) {
        throw InputError(place, "\"" + path + "\" is not a flat image with pixels");
    }
    const auto pixels = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
    const int channels = spec.nchannels < 3 ? 1 : 3;
    std::vector<float> values(pixels * static_cast<std::size_t>(channels));
    if (!input->read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, values.data())) {
        throw InputError(place, "\"" + path + "\" cannot be read as an image: " + input->geterror());
    }
    const bool srgb = is_srgb(spec);
    Image image{spec.width, spec.height, std::vector<float>(3 * pixels)};
    for (std::size_t i = 0; i < pixels; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            const float value = values[channels == 1 ? i : 3 * i + c];
            if (!std::isfinite(value)) throw InputError(place, "\"" + path + "\" has a pixel that is not finite");
            image.rgb[3 * i + c] = srgb ? linear_from_srgb(value) : value;
        }
    }
    return image;
}

}  // namespace kagero
