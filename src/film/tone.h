/// From the light of a picture to the colours of a display.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace kagero {

/// Curve from the brightness of the light to that of the display. `clip` is proportional up to the brightness 1 of the
/// display, and cuts off what is brighter. `filmic` compresses bright and dark light as film does.
enum class ToneCurve { clip, filmic };
/// Returns the names of the values of ToneCurve in scene files, in the same order.
const std::vector<std::string>& tone_curve_names();

/// The keys `exposure` and `tone` of [film].
struct Tone {
    double exposure = 0;  ///< In stops: the light is multiplied by 2^exposure before the curve.
    ToneCurve curve = ToneCurve::clip;
};
/// Greatest legal |exposure|, in stops.
inline constexpr double max_exposure = 64;

/// Returns the brightness of the display for light of the given brightness, from 0 to 1: the filmic curve of J. Hable
/// (Filmic Tonemapping Operators, 2010; presented at GDC 2010), with his exposure bias of 2 and white at 11.2.
double filmic_brightness(double light);

/// Encodes `count` components of linear RGB colours, three for each pixel, as 8-bit sRGB for a display.
///
/// The filmic curve is applied to the greatest component of a colour, and the others keep their ratios to it, so the
/// hue does not change. Light that the curve compresses strongly is mixed with white of the same greatest component, as
/// it looks to the eye. The mixture is that of the Khronos PBR Neutral tone mapper (2024). NaN becomes 0.
std::vector<unsigned char> display_bytes(const float* rgb, std::size_t count, const Tone& tone);

}  // namespace kagero
