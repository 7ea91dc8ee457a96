#include "render/percentiles.h"

#include <cmath>
#include <functional>
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
    if (bins_.empty()) bins_.resize(ValueBins::exponents);
    bins_[exponent].resize(ValueBins::fractions);
}

void PercentileHistogram::add(const PercentileHistogram& other) {
    if (other.empty()) return;
    bins_.resize(ValueBins::exponents);
    for (std::size_t exponent = 0; exponent < ValueBins::exponents; ++exponent) {
        Bins& bins = bins_[exponent];
        const Bins& added = other.bins_[exponent];
        if (added.empty()) continue;
        bins.resize(ValueBins::fractions);
        std::transform(bins.begin(), bins.end(), added.begin(), bins.begin(), std::plus<>());
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
    for (std::uint32_t exponent = 0; exponent < fractions_.size(); ++exponent) {
        for (const std::uint8_t fraction : fractions_[exponent])
            add_to_bin(exponent << ValueBins::fraction_bits | fraction, 1);
        fractions_[exponent].clear();
    }
    listed_ = 0;
}

ValueCounts ValueCounter::take() {
    if (!counts_.bins.empty()) count_list();
    for (const ValueCounts::Bin& bin : counts_.bins) places_[bin.index] = 0;
    ValueCounts counts = std::exchange(counts_, {});
    counts.fractions.reserve(listed_);
    for (std::uint32_t exponent = 0; exponent < fractions_.size(); ++exponent) {
        std::vector<std::uint8_t>& listed = fractions_[exponent];
        if (listed.empty()) continue;
        counts.groups.push_back({exponent, static_cast<std::uint32_t>(listed.size())});
        counts.fractions.insert(counts.fractions.end(), listed.begin(), listed.end());
        listed.clear();
    }
    listed_ = 0;
    return counts;
}

bool ValueCounts::is_legal() const {
    std::uint64_t listed = 0;
    for (const Group& group : groups) {
        if (group.exponent >= ValueBins::exponents) return false;
        listed += group.count;
    }
    return listed == fractions.size() &&
           std::all_of(bins.begin(), bins.end(), [](const Bin& bin) { return bin.index < ValueBins::count; });
}

void PercentileHistogram::add(const ValueCounts& counts) {
    auto fraction = counts.fractions.begin();
    for (const auto& [exponent, count] : counts.groups) {
        Bins& bins = bins_of(exponent);
        for (const auto end = fraction + count; fraction != end; ++fraction) ++bins[*fraction];
    }
    total_ += counts.fractions.size();
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
        const Bins& bins = bins_[exponent];
        for (std::uint64_t fraction = 0; fraction < bins.size(); ++fraction) {
            counted += bins[fraction];
            if (counted < rank) continue;
            const std::uint64_t bin = exponent * ValueBins::fractions + fraction;
            if (bin == 0) return 0;
            return std::min(max_, std::bit_cast<double>((ValueBins::first + bin + 1) << ValueBins::dropped_bits));
        }
    }
    return max_;  // not reached, because the rank is at most total_
}

Percentiles PercentileHistogram::percentiles() const {
    if (empty()) return percentiles_of({});
    return {quantile(0.5), quantile(0.9), quantile(0.99), max_};
}

}  // namespace kagero
