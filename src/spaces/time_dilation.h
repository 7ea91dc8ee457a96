/// Time dilation of matter on circular orbits, from a table.
#pragma once

#include <functional>
#include <vector>

namespace kagero {

/// dt/dτ of matter, as a function of its distance from the axis: the time of the coordinates per time of the matter.
/// Most of the time of a disk's pixel would otherwise be spent on the metric at its position.
class TimeDilation {
public:
    TimeDilation() = default;
    /// Tabulates `exact` between two distances. It returns NaN where matter would not be slower than light.
    TimeDilation(double inner, double outer, const std::function<double(double)>& exact);

    /// Returns dt/dτ with a relative error of at most 1e-10; NaN where the table is not that accurate, or has no value.
    double at(double distance) const;

private:
    static constexpr std::size_t intervals = 1024;
    static constexpr double max_error = 1e-10;

    double interpolated(double node) const;

    double inner_ = 1, nodes_per_logarithm_ = 0;
    std::vector<double> nodes_;      ///< At distances whose logarithms are equidistant; one beyond either end.
    std::vector<bool> is_accurate_;  ///< For each interval.
};

}  // namespace kagero
