#include "film/tone.h"

#include "film/image.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Returns Hable's curve before its scale; all numbers are his.
double hable(double x) {
    constexpr double shoulder = 0.15, linear = 0.50, linear_angle = 0.10, toe = 0.20, toe_numerator = 0.02,
                     toe_denominator = 0.30;
    return (x * (shoulder * x + linear_angle * linear) + toe * toe_numerator) /
               (x * (shoulder * x + linear) + toe * toe_denominator) -
           toe_numerator / toe_denominator;
}

/// Applies the filmic curve to one colour. A colour whose greatest component is not a positive number is unchanged.
void apply_filmic(float (&rgb)[3]) {
    constexpr double desaturation = 0.15;  // of Khronos PBR Neutral
    const double peak = std::max({rgb[0], rgb[1], rgb[2]});
    if (!(peak > 0) || !std::isfinite(peak)) return;
    const double bright = filmic_brightness(peak), color_share = 1 / (desaturation * (peak - bright) + 1);
    for (float& channel : rgb)
        channel = static_cast<float>(bright + color_share * (channel * (bright / peak) - bright));
}

}  // namespace

const std::vector<std::string>& tone_curve_names() {
    static const std::vector<std::string> names{"clip", "filmic"};
    return names;
}

double filmic_brightness(double light) {
    constexpr double exposure_bias = 2, white = 11.2;
    return std::clamp(hable(exposure_bias * light) / hable(white), 0.0, 1.0);
}

std::vector<unsigned char> display_bytes(const float* rgb, std::size_t count, const Tone& tone) {
    std::vector<unsigned char> bytes(count);
    const float factor = static_cast<float>(std::exp2(tone.exposure));
    for (std::size_t i = 0; i < count; i += 3) {
        float color[3];
        for (std::size_t k = 0; k < 3; ++k) color[k] = factor * rgb[i + k];
        if (tone.curve == ToneCurve::filmic) apply_filmic(color);
        for (std::size_t k = 0; k < 3; ++k) bytes[i + k] = encode_srgb(color[k]);
    }
    return bytes;
}

}  // namespace kagero
