/// Statistics of repeated time measurements.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace kagero {

/// Median, minimum and maximum over repeated runs, in the unit of the measurements. NaN if there were no runs.
struct Timing {
    double median = 0, min = 0, max = 0;
};

/// Returns the statistics of a list of times.
inline Timing timing_of(std::vector<double> times) {
    const std::size_t n = times.size();
    if (n == 0) return {std::nan(""), std::nan(""), std::nan("")};
    std::sort(times.begin(), times.end());
    return {0.5 * (times[(n - 1) / 2] + times[n / 2]), times.front(), times.back()};
}

}  // namespace kagero
