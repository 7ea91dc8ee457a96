#include "render/percentiles.h"

#include <cmath>
#include <limits>
#include <utility>

namespace kagero {

Percentiles percentiles_of(std::vector<double> values) {
    constexpr double undefined = std::numeric_limits<double>::quiet_NaN();
    if (values.empty()) return {undefined, undefined, undefined, undefined};
    auto unsorted = values.begin();  // No value before this position is greater than a value at or after it.
    const auto quantile = [&](double share) {
        const auto ranked =
            values.begin() + static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(values.size()))) - 1;
        std::nth_element(unsorted, ranked, values.end());
        return *(unsorted = ranked);
    };
    return {quantile(0.5), quantile(0.9), quantile(0.99), quantile(1.0)};
}

/// Adds the bins of an exponent.
void PercentileHistogram::add_bins(std::size_t exponent) {
    counts_.resize(counts_.size() + ValueBins::fractions);
    ends_[exponent] = static_cast<std::uint32_t>(counts_.size());
}

void PercentileHistogram::add(const PercentileHistogram& other) {
    for (std::uint32_t exponent = 0; exponent < ValueBins::exponents; ++exponent) {
        std::uint32_t bin = exponent << ValueBins::fraction_bits;
        for (const std::uint64_t count : other.counts_of(exponent)) count_of(bin++) += count;
    }
    total_ += other.total_;
    max_ = std::max(max_, other.max_);
}

/// Counts values of one bin.
void ValueCounter::add_to_bin(std::uint32_t index, std::uint32_t count) {
    if (places_.empty()) places_.resize(ValueBins::count);
    std::uint32_t& place = places_[index];
    if (place == 0) {
        counts_.bins.push_back({index, 0});
        place = static_cast<std::uint32_t>(counts_.bins.size());
    }
    counts_.bins[place - 1].count += count;
}

/// Moves the values of the list to the bins.
void ValueCounter::count_list() {
    for (const std::uint16_t bin : counts_.listed) add_to_bin(bin, 1);
    counts_.listed.clear();
}

ValueCounts ValueCounter::take() {
    if (!counts_.bins.empty()) count_list();
    for (const ValueCounts::Bin& bin : counts_.bins) places_[bin.index] = 0;
    ValueCounts counts = std::exchange(counts_, {});
    counts_.listed.reserve(counts.listed.size());  // tiles have about the same number of values
    return counts;
}

void PercentileHistogram::add(const ValueCounts& counts) {
    for (const std::uint16_t bin : counts.listed) ++count_of(bin);
    total_ += counts.listed.size();
    for (const auto& [index, count] : counts.bins) {
        count_of(index) += count;
        total_ += count;
    }
    max_ = std::max(max_, counts.max);
}

/// Returns the upper bound of the bin that contains the value of rank share · total_, but at most the greatest value.
/// Returns 0 for the first bin.
double PercentileHistogram::quantile(double share) const {
    const auto rank = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(total_)));
    std::uint64_t counted = 0;
    for (std::uint64_t exponent = 0; exponent < ValueBins::exponents; ++exponent) {
        std::uint64_t bin = exponent << ValueBins::fraction_bits;
        for (const std::uint64_t count : counts_of(exponent)) {
            counted += count;
            ++bin;
            if (counted < rank) continue;
            if (bin == 1) return 0;
            return std::min(max_, std::bit_cast<double>((ValueBins::first + bin) << ValueBins::dropped_bits));
        }
    }
    return max_;  // not reached, because the rank is at most total_
}

Percentiles PercentileHistogram::percentiles() const {
    if (empty()) return percentiles_of({});
    return {quantile(0.5), quantile(0.9), quantile(0.99), max_};
}

}  // namespace kagero
