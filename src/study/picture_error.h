/// Error of a small picture against a reference picture.
#pragma once

#include "plan/variant.h"

#include <string>

namespace kagero {

/// Difference between the pictures of one variant and of the reference.
struct PictureError {
    std::string method;
    Precision precision{};
    bool adaptive = false;
    double step = 0;             ///< Step in the unit of a scene file, or the tolerance of an adaptive method.
    double gradients = 0;        ///< Gradient evaluations per ray, mean over the sample rays of the study.
    double seconds = 0;          ///< Time to render the picture.
    double wrong_pixels = 0;     ///< Share of pixels with a linear colour component that differs by more than 1/255.
    double rms = 0;              ///< Root mean square difference of linear colour components; white is 1.
    std::optional<double> psnr;  ///< Peak signal-to-noise ratio in decibels. Empty for equal pictures.
};

/// The picture of the scene, and the error of each pixel's ray end. An error is NaN if the two ray ends that are
/// compared differ in status or object, or if their status is `step_limit` or `failed`.
struct ErrorMap {
    std::uint32_t width = 0, height = 0;
    std::vector<float> color;     ///< Linear RGB.
    Tone tone{};                  ///< Conversion of `color` for displays.
    std::vector<float> estimate;  ///< Estimated error, the layer `position_error`, in pixels.
    std::vector<float> truth;     ///< Distance to the reference ray end, in pixels.
};

/// Returns the error map of the plan's method and step, relative to the variant `reference`. The picture is at most
/// `width` pixels wide, with one ray per pixel. The map is empty if `stop` is set.
ErrorMap error_map(const Plan& plan, std::uint32_t width, const Variant& reference, const std::atomic<bool>* stop);

/// Renders the scene's picture, at most `width` pixels wide, with each variant and with `reference`. Returns the errors
/// of the variants, in their order; the list is shorter if `stop` is set.
std::vector<PictureError> picture_errors(const Plan& plan, std::uint32_t width, const Variant& reference,
                                         const std::vector<Variant>& variants, const std::atomic<bool>* stop);

}  // namespace kagero
