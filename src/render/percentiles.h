/// Percentiles of a quantity over rays.
#pragma once

#include <algorithm>
#include <bit>
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

/// Bins of values. A bin is identified by the leading bits of a double: the exponent, from −128 to 127, and the first
/// eight bits of the fraction.
struct ValueBins {
    static constexpr int fraction_bits = 8, dropped_bits = 52 - fraction_bits;
    static constexpr std::uint64_t exponents = 256, fractions = std::uint64_t(1) << fraction_bits;
    static constexpr std::uint64_t count = exponents * fractions;
    static constexpr std::uint64_t first = std::uint64_t(1023 - 128) << fraction_bits;

    /// Returns the index of the bin of a value, below `count`.
    static std::uint16_t bin_of(double value) {
        const std::uint64_t leading = std::bit_cast<std::uint64_t>(value) >> dropped_bits;
        return static_cast<std::uint16_t>(std::clamp(leading, first, first + count - 1) - first);
    }
};

/// The values of a tile, counted in ValueBins. Few values are listed one by one, in one byte each, which needs the
/// least time and memory.
struct ValueCounts {
    /// Listed values with the same exponent.
    struct Group {
        std::uint32_t exponent, count;
    };
    /// A bin, and the number of values in it.
    struct Bin {
        std::uint32_t index, count;
    };
    std::vector<Group> groups;            ///< Empty if there are many values.
    std::vector<std::uint8_t> fractions;  ///< The fraction bits of each listed value, group by group.
    std::vector<Bin> bins;  ///< The bins that contain values, in any order; empty if there are few values.
    double max = 0;         ///< The greatest value.

    /// Returns true if all numbers are legal, as they are unless they were read from a damaged file.
    bool is_legal() const;
};

/// Counts the values of one tile after another, in constant time per value.
class ValueCounter {
public:
    /// Counts a value, which must not be negative or NaN.
    void add(double value) {
        if (listed_ == longest_list) count_list();
        if (fractions_.empty()) fractions_.resize(ValueBins::exponents);
        const std::uint16_t bin = ValueBins::bin_of(value);
        fractions_[bin >> ValueBins::fraction_bits].push_back(static_cast<std::uint8_t>(bin));
        ++listed_;
        counts_.max = std::max(counts_.max, value);
    }
    /// Counts a value `count` times. It must not be negative or NaN.
    void add(double value, std::uint32_t count) {
        add_to_bin(ValueBins::bin_of(value), count);
        counts_.max = std::max(counts_.max, value);
    }
    /// Returns the counts of all values since the last call.
    ValueCounts take();

private:
    static constexpr std::size_t longest_list = 4096;

    void add_to_bin(std::uint32_t index, std::uint32_t count);
    void count_list();

    std::vector<std::vector<std::uint8_t>> fractions_;  ///< For each exponent, the fraction bits of listed values.
    std::size_t listed_ = 0;                            ///< Number of listed values.
    std::vector<std::uint32_t> places_;  ///< For each bin, its place in `counts_`, plus 1; 0: none.
    ValueCounts counts_;
};

/// A histogram for the percentiles of more values than fit into memory. Values must not be negative or NaN. The
/// histogram uses six kilobytes, and two more for each exponent of its values. Percentiles are too large by at most a
/// factor 1 + 1/256; the greatest value is exact. Values below 3e-39 count as 0.
class PercentileHistogram {
public:
    void add(double value) {
        ++count_of(ValueBins::bin_of(value));
        ++total_;
        max_ = std::max(max_, value);
    }
    void add(const PercentileHistogram& other);
    void add(const ValueCounts& counts);
    bool empty() const { return total_ == 0; }
    Percentiles percentiles() const;

private:
    /// Numbers of values in the bins of one exponent; empty until the first value with the exponent is added.
    using Bins = std::vector<std::uint64_t>;

    /// Returns the bins of an exponent, to be changed.
    Bins& bins_of(std::size_t exponent) {
        if (bins_.empty() || bins_[exponent].empty()) add_bins(exponent);
        return bins_[exponent];
    }
    /// Returns the number of values in a bin, to be changed.
    std::uint64_t& count_of(std::uint32_t bin) {
        return bins_of(bin >> ValueBins::fraction_bits)[bin % ValueBins::fractions];
    }
    void add_bins(std::size_t exponent);
    double quantile(double share) const;

    std::vector<Bins> bins_;  ///< One element per exponent; empty until the first value is added.
    std::uint64_t total_ = 0;
    double max_ = 0;
};

}  // namespace kagero
