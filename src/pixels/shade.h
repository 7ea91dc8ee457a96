/// Computation of pixels from the ends of their rays.
#pragma once

#include "appearance/footprint.h"
#include "film/film.h"
#include "plan/plan.h"

#include <span>
#include <vector>

namespace kagero {

/// Data that layers need in addition to the ends of rays, as bits of a set.
enum Need : unsigned {
    need_start = 1,            ///< PixelSample::ray.
    need_footprint = 2,        ///< PixelSample::footprint.
    need_energy_error = 4,     ///< RayEnd::energy_error.
    need_position_error = 8,   ///< EndError::position.
    need_rounding_error = 16,  ///< EndError::rounding.
    need_action = 32,          ///< RayEnd::action.
    need_time = 64             ///< RayEnd::time.
};
inline constexpr unsigned need_any_error = need_energy_error | need_position_error | need_rounding_error;

/// Returns the data that a layer needs, as bits of Need. Throws RunError if the table of layers has no such layer.
unsigned needs_of(const std::string& layer);
/// Returns the data that all layers of a film need, as bits of Need.
unsigned needs_of(const Film& film);

/// Data from which a pixel is computed.
struct Pixel {
    const Plan& plan;
    std::span<const PixelSample> rays;  ///< At least one ray.
    std::uint32_t x, y;                 ///< Position on the whole picture, also if the film is a crop.
};

/// Writes the pixels of all layers of a film, which must outlive this object.
class Shader {
public:
    explicit Shader(Film& film);
    /// Computes all layers of a pixel and writes them to pixel (x, y) of the film.
    void shade(const Pixel& pixel, std::uint32_t x, std::uint32_t y) const;

private:
    /// A layer of the film.
    struct Layer {
        void (*write)(const Pixel&, float*);  ///< Computes the layer for a pixel and writes its channels.
        float* plane;
        std::size_t channels;
    };
    std::vector<Layer> layers_;
    std::size_t width_;
};

}  // namespace kagero
