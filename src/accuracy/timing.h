/// Repeated measurements of one time.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace kagero {

/// Over the repeated runs; not numbers where there were none.
struct Timing {
    double median = 0, min = 0, max = 0;
};

inline Timing timing_of(std::vector<double> times) {
    const std::size_t n = times.size();
    if (n == 0) return {std::nan(""), std::nan(""), std::nan("")};
    std::sort(times.begin(), times.end());
    return {0.5 * (times[(n - 1) / 2] + times[n / 2]), times.front(), times.back()};
}

}  // namespace kagero
