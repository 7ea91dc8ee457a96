/// Encodes small pictures as PNG files in memory, for HTML pages that contain them.
#pragma once

#include <vector>

namespace kagero {

/// Maps positions on a scale in [0, 1] to false colours, dark to bright, as bytes of RGB. Negative positions become
/// grey.
std::vector<unsigned char> false_colored(const std::vector<float>& positions);

/// Returns the PNG file of a picture of linear RGB, row by row from the top.
std::vector<unsigned char> png_of_colors(const std::vector<float>& rgb, int width, int height);
/// Returns the PNG file of positions on a scale, in false colours.
std::vector<unsigned char> png_of_false_colors(const std::vector<float>& positions, int width, int height);

}  // namespace kagero
