/// Picture files in memory, for the pages of the viewer.
#pragma once

#include "film/film.h"

namespace kagero {

/// A picture file in memory.
struct EncodedPicture {
    std::string type;  ///< Media type, such as "image/png".
    std::vector<unsigned char> bytes;
    double least = 0, greatest = 0;  ///< Values at the ends of the scale of false colours; 0 for colours.
};

/// Encodes a layer: colours with the film's tone, numbers in false colours. Moving pictures are JPEG files, which are
/// encoded faster; other pictures are PNG files without loss.
EncodedPicture encode_layer(const Film& film, const std::string& layer, bool is_moving);

/// Encodes RGB bytes of a moving picture as JPEG.
EncodedPicture encode_moving(const std::vector<unsigned char>& rgb, std::uint32_t width, std::uint32_t height);

}  // namespace kagero
