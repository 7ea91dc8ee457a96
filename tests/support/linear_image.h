/// Conversions of images between linear floats and the form in which files are read.
#pragma once

#include "film/image.h"

namespace kagero::test {

/// Returns an image with linear floats.
inline Image linear_image(const StoredImage& stored) {
    return visit_texels(stored, [](const auto& texels) {
        Image image{texels.width, texels.height, {}};
        const std::size_t size = 3 * std::size_t(texels.width) * std::size_t(texels.height);
        for (std::size_t i = 0; i < size; ++i) image.rgb.push_back(texels[i]);
        return image;
    });
}

/// Returns an image like that of a file with linear floats.
inline StoredImage stored_image(const Image& image) { return {image.width, image.height, image.rgb}; }

}  // namespace kagero::test
