/// Percentiles of a quantity over rays.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
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

/// The values of a tile, counted in ValueBins. Few values are listed one by one, which needs the least time.
struct ValueCounts {
    /// A bin, and the number of values in it.
    struct Bin {
        std::uint32_t index, count;
    };
    std::vector<std::uint16_t> listed;  ///< The bin of each value; empty if there are many values.
    std::vector<Bin> bins;  ///< The bins that contain values, in any order; empty if there are few values.
    double max = 0;         ///< The greatest value.

    /// Returns true if all numbers are legal, as they are unless they were read from a damaged file.
    bool is_legal() const {
        return std::all_of(bins.begin(), bins.end(), [](const Bin& bin) { return bin.index < ValueBins::count; });
    }
};

/// Counts the values of one tile after another, in constant time per value.
class ValueCounter {
public:
    /// Counts a value, which must not be negative or NaN.
    void add(double value) {
        if (counts_.listed.size() == longest_list) count_list();
        counts_.listed.push_back(ValueBins::bin_of(value));
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

    std::vector<std::uint32_t> places_;  ///< For each bin, its place in `counts_`, plus 1; 0: none.
    ValueCounts counts_;
};

/// A histogram for the percentiles of more values than fit into memory. Values must not be negative or NaN. The
/// histogram uses one kilobyte, and two more for each exponent of its values. Percentiles are too large by at most a
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
    /// Returns the number of values in a bin, to be changed.
    std::uint64_t& count_of(std::uint32_t bin) {
        const std::uint32_t exponent = bin >> ValueBins::fraction_bits;
        if (ends_[exponent] == 0) add_bins(exponent);
        return counts_[ends_[exponent] - ValueBins::fractions + bin % ValueBins::fractions];
    }
    /// Returns the numbers of values in the bins of an exponent. The list is empty if no value has it.
    std::span<const std::uint64_t> counts_of(std::size_t exponent) const {
        const std::uint32_t end = ends_[exponent];
        return {counts_.data() + (end == 0 ? 0 : end - ValueBins::fractions), end == 0 ? 0 : ValueBins::fractions};
    }
    void add_bins(std::size_t exponent);
    double quantile(double share) const;

    std::vector<std::uint64_t> counts_;  ///< Numbers of values in the bins of those exponents that values have.
    std::array<std::uint32_t, ValueBins::exponents> ends_{};  ///< End of the bins of each exponent; 0: no value has it.
    std::uint64_t total_ = 0;
    double max_ = 0;
};

}  // namespace kagero
