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

/// Reads any format OpenImageIO knows; 8-bit images are sRGB-decoded, EXR and other float images are taken as linear; grey becomes RGB,
/// alpha is dropped. Throws InputError at `place` when the file is missing, unreadable or empty.
Image read_image(const std::string& path, const Place& place);

/// sRGB of a linear colour; what is not a number is black.
unsigned char encode_srgb(float linear);

/// Shares in [0, 1] as bytes of RGB, dark to bright in false colours; grey where there is none (below 0).
std::vector<unsigned char> false_colored(const std::vector<float>& shares);

/// The files of PNG pictures, row by row from the top: of linear RGB …
std::vector<unsigned char> png_of_colors(const std::vector<float>& rgb, int width, int height);
/// … and of shares, in false colours.
std::vector<unsigned char> png_of_shares(const std::vector<float>& shares, int width, int height);

}  // namespace kagero
