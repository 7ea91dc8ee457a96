/// Percentiles of something over rays.
#pragma once

#include <cstdint>
#include <vector>

namespace kagero {

struct Spread {
    double p50 = 0, p90 = 0, p99 = 0, max = 0;
};
/// By the nearest rank: no less than this share of the values is as small as that. Of no values at all: not numbers.
Spread spread_of(std::vector<double> values);

/// The same of values that are too many to keep, none of them negative or not a number: in half a megabyte, its
/// percentiles at most 1/256 too great. The greatest is exact; below 3e-39 a value is 0.
class Tally {
public:
    void add(double value);
    void add(const Tally& other);
    bool empty() const { return total_ == 0; }
    Spread spread() const;

private:
    double at(double share) const;

    std::vector<std::uint64_t> bins_;  ///< none before there is a value
    std::uint64_t total_ = 0;
    double max_ = 0;
};

}  // namespace kagero
