/// Greatest errors in tests.
#pragma once

#include <cmath>
#include <limits>

namespace kagero::test {

/// The greater of two errors; what is not a number is greater than any.
inline double greatest(double a, double b) {
    if (std::isnan(a) || std::isnan(b)) return std::numeric_limits<double>::infinity();
    return a < b ? b : a;
}

}  // namespace kagero::test
