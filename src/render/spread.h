/// Percentiles of something over rays.
#pragma once

#include <vector>

namespace kagero {

struct Spread {
    double p50 = 0, p90 = 0, p99 = 0, max = 0;
};
/// By the nearest rank: no less than this share of the values is as small as that. Of no values at all: not numbers.
Spread spread_of(std::vector<double> values);

}  // namespace kagero
