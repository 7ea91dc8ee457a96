/// A small picture against the picture it should be.
#pragma once

#include "plan/variant.h"

#include <string>

namespace kagero {

struct PictureError {
    std::string method;
    Precision precision{};
    bool adaptive = false;
    double step = 0;             ///< of adaptive methods: the tolerance
    double gradients = 0;        ///< per ray, of the sample of the study
    double seconds = 0;          ///< of rendering
    double wrong_pixels = 0;     ///< share of pixels of which a colour differs by more than 1/255, linear
    double rms = 0;              ///< over all colours, linear; 1 is white
    std::optional<double> psnr;  ///< decibels below white; none for equal pictures
};

/// The scene's own picture, and how wrong its rays are, pixel by pixel; not a number where that is not known.
struct ErrorMap {
    std::uint32_t width = 0, height = 0;
    std::vector<float> color;            ///< linear RGB
    std::vector<float> estimate, truth;  ///< pixels: the layer `position_error`, and the distance to the reference
};

/// At most `width` pixels wide, one ray per pixel; by the plan's own method against `reference`.
ErrorMap error_map(const Plan& plan, std::uint32_t width, const Variant& reference, const std::atomic<bool>* stop);

/// The scene's picture at most `width` pixels wide, by each variant, against that by `reference`.
std::vector<PictureError> picture_errors(const Plan& plan, std::uint32_t width, const Variant& reference,
                                         const std::vector<Variant>& variants, const std::atomic<bool>* stop);

}  // namespace kagero
