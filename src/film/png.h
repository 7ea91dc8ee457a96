/// Encodes small pictures as PNG files in memory, for HTML pages that contain them.
#pragma once

#include "film/tone.h"

#include <vector>

namespace kagero {

/// Maps positions on a scale, from 0 (dark) to 1 (bright), to false colours in RGB, with one byte per channel. Negative
/// positions and NaN become grey.
std::vector<unsigned char> false_colored(const std::vector<float>& positions);

/// Returns the PNG file of a picture. `rgb` contains linear RGB, row by row from the top.
std::vector<unsigned char> png_of_colors(const std::vector<float>& rgb, int width, int height, const Tone& tone);
/// Returns the PNG file of a picture in false colours. `positions` contains one position on the scale per pixel.
std::vector<unsigned char> png_of_false_colors(const std::vector<float>& positions, int width, int height);

}  // namespace kagero
