#include "adaptive/displacement.h"

#include <algorithm>
#include <cmath>

namespace kagero {

double displacement_in_pixels(const EndDerivatives& derivatives, const Double3& error, double pixel_size) {
    const auto& [right, down] = derivatives;
    // The principal axes of the map J are the eigenvectors of JᵀJ. One of them is at the angle φ to the right.
    const double xx = dot(right, right), xy = dot(right, down), yy = dot(down, down);
    const double phi = 0.5 * std::atan2(2 * xy, xx - yy), c = std::cos(phi), s = std::sin(phi);
    Double3 rest = error;
    double sum = 0;
    for (const Double3& axis : {add(scaled(right, c), scaled(down, s)), subtract(scaled(down, c), scaled(right, s))}) {
        const double stretch = length(axis);
        if (!(stretch > pixel_size)) continue;
        const double part = dot(error, axis) / stretch;
        sum += (part / stretch) * (part / stretch);
        rest = subtract(rest, scaled(axis, part / stretch));
    }
    return std::sqrt(sum + dot(rest, rest) / (pixel_size * pixel_size));
}

}  // namespace kagero
