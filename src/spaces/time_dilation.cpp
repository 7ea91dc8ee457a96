#include "spaces/time_dilation.h"

#include <cmath>
#include <limits>

namespace kagero {

TimeDilation::TimeDilation(double inner, double outer, const std::function<double(double)>& exact)
    : inner_(inner), nodes_per_logarithm_(double(intervals) / std::log(outer / inner)), is_accurate_(intervals) {
    const auto distance_of = [&](double node) { return inner_ * std::exp(node / nodes_per_logarithm_); };
    for (std::size_t i = 0; i < intervals + 3; ++i) nodes_.push_back(exact(distance_of(double(i) - 1)));
    for (std::size_t i = 0; i < intervals; ++i) {
        const double middle = double(i) + 0.5, expected = exact(distance_of(middle));
        is_accurate_[i] = std::abs(interpolated(middle) - expected) <= max_error * expected;
    }
}

/// Interpolates between four nodes, with the cubic polynomial of Lagrange. `node` counts from 0 at the inner distance.
double TimeDilation::interpolated(double node) const {
    const auto i = static_cast<std::size_t>(node);
    const double t = node - double(i);
    const double* f = &nodes_[i];
    return t * (t - 1) * ((t + 1) * f[3] - (t - 2) * f[0]) / 6 + (t + 1) * (t - 2) * ((t - 1) * f[1] - t * f[2]) / 2;
}

double TimeDilation::at(double distance) const {
    const double node = nodes_.empty() ? -1 : std::log(distance / inner_) * nodes_per_logarithm_;
    if (!(node >= 0 && node < double(intervals)) || !is_accurate_[static_cast<std::size_t>(node)])
        return std::numeric_limits<double>::quiet_NaN();
    return interpolated(node);
}

}  // namespace kagero
