/// Small pictures as PNG files in memory, for pages that hold them.
#pragma once

#include <vector>

namespace kagero {

/// Shares in [0, 1] as bytes of RGB, dark to bright in false colours; grey where there is none (below 0).
std::vector<unsigned char> false_colored(const std::vector<float>& shares);

/// The files of PNG pictures, row by row from the top: of linear RGB …
std::vector<unsigned char> png_of_colors(const std::vector<float>& rgb, int width, int height);
/// … and of shares, in false colours.
std::vector<unsigned char> png_of_shares(const std::vector<float>& shares, int width, int height);

}  // namespace kagero
