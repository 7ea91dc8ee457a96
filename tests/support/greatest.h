/// Maximum of errors, in which NaN counts as an infinite error.
#pragma once

#include <cmath>
#include <limits>

namespace kagero::test {

/// Returns the greater of two errors, or infinity if one of them is NaN.
inline double greatest(double a, double b) {
    if (std::isnan(a) || std::isnan(b)) return std::numeric_limits<double>::infinity();
    return a < b ? b : a;
}

}  // namespace kagero::test
