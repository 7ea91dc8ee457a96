/// Interpolation of the ends of rays in a square cell of the picture.
#pragma once

#include "kernels/abi.h"

#include <array>

namespace kagero {

/// Ends of 3 × 3 rays at equal distances, row by row.
using EndLattice = std::array<const RayEnd*, 9>;

/// Biquadratic interpolation between 3 × 3 ends of rays that have the same status and end on the same face. Positions
/// in the cell are (u, v) with 0 ≤ u, v ≤ 2; the rays are at the integers. The error is of the third order in the
/// distance of the rays.
///
/// Position, momentum, direction, parameter, action and time are interpolated. All other members are those of the ray
/// in the middle, and the energy error is NaN.
class EndInterpolant {
public:
    explicit EndInterpolant(const EndLattice& ends);
    /// Prepares the interpolation along the row v.
    void set_row(double v);
    /// Writes the end at position u of the row.
    void write(double u, RayEnd& end) const;

private:
    static constexpr std::size_t components = 12;
    using Values = std::array<double, components>;

    static Values values_of(const RayEnd& end);

    const RayEnd& middle_;
    std::array<Values, 9> nodes_;
    Values constant_{}, linear_{}, quadratic_{};  ///< Coefficients of the powers of u in the row.
};

}  // namespace kagero
