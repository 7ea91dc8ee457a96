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

void PercentileHistogram::add(double value) {
    if (bins_.empty()) bins_.resize(ValueBins::count);
    ++bins_[ValueBins::bin_of(value)];
    ++total_;
    max_ = std::max(max_, value);
}

void PercentileHistogram::add(const PercentileHistogram& other) {
    if (other.empty()) return;
    bins_.resize(ValueBins::count);
    std::transform(bins_.begin(), bins_.end(), other.bins_.begin(), bins_.begin(), std::plus<>());
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
    for (const std::uint16_t index : counts_.list) add_to_bin(index, 1);
    counts_.list.clear();
}

ValueCounts ValueCounter::take() {
    if (!counts_.bins.empty()) count_list();
    for (const ValueCounts::Bin& bin : counts_.bins) places_[bin.index] = 0;
    const std::size_t listed = counts_.list.size();
    ValueCounts counts = std::exchange(counts_, {});
    counts_.list.reserve(listed);  // The next tile has about as many values.
    return counts;
}

void PercentileHistogram::add(const ValueCounts& counts) {
    if (counts.bins.empty() && counts.list.empty()) return;
    bins_.resize(ValueBins::count);
    for (const std::uint16_t index : counts.list) ++bins_[index];
    total_ += counts.list.size();
    for (const auto& [index, count] : counts.bins) {
        bins_.at(index) += count;
        total_ += count;
    }
    max_ = std::max(max_, counts.max);
}

/// Returns the upper bound of the bin that contains the value of rank share · total_, but at most the greatest value.
/// Returns 0 for the first bin.
double PercentileHistogram::quantile(double share) const {
    const auto rank = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(total_)));
    std::uint64_t bin = 0;
    for (std::uint64_t counted = bins_[0]; counted < rank; counted += bins_[++bin]) {
    }
    return bin == 0 ? 0
                    : std::min(max_, std::bit_cast<double>((ValueBins::first + bin + 1) << ValueBins::dropped_bits));
}

Percentiles PercentileHistogram::percentiles() const {
    if (empty()) return percentiles_of({});
    return {quantile(0.5), quantile(0.9), quantile(0.99), max_};
}

}  // namespace kagero
