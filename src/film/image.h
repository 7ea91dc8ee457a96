/// Images in memory, and reading of image files.
#pragma once

#include "error.h"

#include <string>
#include <vector>

namespace kagero {

/// An image: linear RGB, three floats per pixel, row by row from the top.
struct Image {
    int width = 0, height = 0;
    std::vector<float> rgb;
};

/// Reads an image file of any format that OpenImageIO supports. sRGB-encoded images are decoded to linear values; EXR
/// and other float images are linear. Grey becomes RGB, and alpha is ignored. Throws InputError at `location` if the
/// file is missing or unreadable, or if a value is not finite.
Image read_image(const std::string& path, const FileLocation& location);

/// Encodes one linear colour component as sRGB. NaN becomes 0.
unsigned char encode_srgb(float linear);

}  // namespace kagero
