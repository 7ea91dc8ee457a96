#include "film/image.h"

#include <algorithm>
#include <cmath>

namespace kagero {

unsigned char encode_srgb(float linear) {
    // The comparison is false if `linear` is NaN, so NaN becomes 0.
    const double x = linear > 0.0f ? std::min(static_cast<double>(linear), 1.0) : 0.0;
    const double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
    return static_cast<unsigned char>(std::lround(255.0 * encoded));
}

}  // namespace kagero
