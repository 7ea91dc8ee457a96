/// Images in memory and on disk.
#pragma once

#include "error.h"

#include <string>
#include <vector>

namespace kagero {

/// Linear RGB, row by row from the top, three floats per pixel.
struct Image {
    int width = 0, height = 0;
    std::vector<float> rgb;
};

/// Reads any format OpenImageIO knows; 8-bit images are sRGB-decoded, EXR and other float images are taken as linear;
/// grey becomes RGB, alpha is dropped. Throws InputError at `place` when the file is missing, unreadable or empty.
Image read_image(const std::string& path, const Place& place);

/// sRGB of a linear colour; what is not a number is black.
unsigned char encode_srgb(float linear);

}  // namespace kagero
