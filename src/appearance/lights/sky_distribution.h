/// A distribution of directions in proportion to the brightness of a sky.
#pragma once

#include "appearance/paints.h"

#include <optional>

namespace kagero {

/// Directions whose density is proportional to the luminance of a sky, constant in each cell of a grid of longitudes
/// and latitudes.
class SkyDistribution {
public:
    /// Returns the distribution of a sky with a texture; nothing if the brightness varies too little, so that
    /// directions toward its bright parts are not worth preferring.
    static std::optional<SkyDistribution> of(const LoadedSky& sky);

    /// Returns the unit direction that belongs to a point in the unit square.
    Double3 direction(const std::array<double, 2>& point) const;
    /// Returns the probability per solid angle of a unit direction.
    double density(const Double3& direction) const;
    /// Returns the mean luminance of the sky.
    double mean_luminance() const { return mean_luminance_; }

private:
    explicit SkyDistribution(const LoadedSky& sky);
    /// Returns the luminance of a cell, or a share of that of its brightest neighbour if this is greater: an
    /// interpolated image is bright beyond the edge of a bright texel.
    double widened_luminance(const std::vector<double>& luminances, std::size_t row, std::size_t column) const;
    double cell_density(std::size_t row, std::size_t column) const;
    /// Returns the sine of the latitude at the upper edge of a row.
    double sine_above(std::size_t row) const;

    SkyAxes axes_;
    std::size_t width_ = 0, height_ = 0;
    std::vector<double> row_sums_;   ///< Sums of the weights of all rows up to each row.
    std::vector<double> cell_sums_;  ///< Sums of the weights in a row up to each cell, row by row from the top.
    double mean_luminance_ = 0, greatest_luminance_ = 0;
};

}  // namespace kagero
