/// Ends of rays to pixels.
#pragma once

#include "appearance/footprint.h"
#include "film/film.h"
#include "plan/plan.h"

#include <span>
#include <vector>

namespace kagero {

/// What layers are made from beside the ends of rays: their starts, the sky that they stand for, and how exact they
/// are.
enum Need : unsigned {
    need_start = 1,
    need_footprint = 2,
    need_energy_error = 4,
    need_position_error = 8,
    need_rounding_error = 16
};
inline constexpr unsigned need_any_error = need_energy_error | need_position_error | need_rounding_error;

/// Of a layer, and of all layers of a film; Need, as bits. Throws RunError for a layer that nothing paints.
unsigned needs_of(const std::string& layer);
unsigned needs_of(const Film& film);

/// How many places of the sky's image are looked up to colour a ray: most of what that costs.
int probes_of(const Plan& plan, const PixelSample& ray, const SkyFootprints& footprints);

/// All that a pixel is made from: its rays, at least one, and its place on the whole picture.
struct Pixel {
    const Plan& plan;
    std::span<const PixelSample> rays;
    const SkyFootprints& footprints;
    std::uint32_t x, y;
};

/// Writes what a film's layers want of pixels. The film outlives it.
class Shader {
public:
    explicit Shader(Film& film);
    /// Into pixel (x, y) of the film.
    void shade(const Pixel& pixel, std::uint32_t x, std::uint32_t y) const;

private:
    struct Layer {
        void (*paint)(const Pixel&, float*);
        float* plane;
        std::size_t channels;
    };
    std::vector<Layer> layers_;
    std::size_t width_;
};

}  // namespace kagero
