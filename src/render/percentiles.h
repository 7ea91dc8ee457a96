/// Percentiles of a quantity over rays.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace kagero {

/// The percentiles 50, 90 and 99, and the greatest value.
struct Percentiles {
    double p50 = 0, p90 = 0, p99 = 0, max = 0;
};
/// Returns the percentiles by the nearest-rank method: percentile n is the least value such that at least n % of the
/// values are not greater. All percentiles are NaN if there are no values.
Percentiles percentiles_of(std::vector<double> values);

/// The values of a tile, counted in the bins of PercentileHistogram. Only bins that contain values are stored.
struct ValueCounts {
    /// A bin, and the number of values in it.
    struct Bin {
        std::uint32_t index, count;
    };
    std::vector<Bin> bins;  ///< In the order of their first values. The same bin can occur more than once.
    double max = 0;         ///< The greatest value.
};

/// Counts the values of one tile after another, in constant time per value.
class ValueCounter {
public:
    /// Counts a value `count` times. It must not be negative or NaN.
    void add(double value, std::uint32_t count = 1);
    /// Returns the counts of all values since the last call.
    ValueCounts take();

private:
    /// Places of bins in `counts_`, plus 1, by the last bits of their indices; 0: none. The table fits into the fastest
    /// cache. If two bins have the same last bits, `counts_` contains them more than once.
    std::array<std::uint32_t, 2048> places_{};
    ValueCounts counts_;
};

/// A histogram for the percentiles of more values than fit into memory. Values must not be negative or NaN. The
/// histogram uses half a megabyte. Percentiles are too large by at most a factor 1 + 1/256; the greatest value is
/// exact. Values below 3e-39 count as 0.
class PercentileHistogram {
public:
    void add(double value);
    void add(const PercentileHistogram& other);
    void add(const ValueCounts& counts);
    bool empty() const { return total_ == 0; }
    Percentiles percentiles() const;

private:
    double quantile(double share) const;

    std::vector<std::uint64_t> bins_;  ///< Number of values in each bin; empty until the first value is added.
    std::uint64_t total_ = 0;
    double max_ = 0;
};

}  // namespace kagero
