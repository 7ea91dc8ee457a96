#include "render/percentiles.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

namespace kagero {
namespace {

// A bin of the histogram is identified by the leading bits of a double: the exponent, from −128 to 127, and the first
// eight bits of the fraction.
constexpr int fraction_bits = 8, dropped_bits = 52 - fraction_bits;
constexpr std::uint64_t bin_count = std::uint64_t(256) << fraction_bits, first_bin = std::uint64_t(1023 - 128)
                                                                                     << fraction_bits;

std::uint64_t bin_of(double value) {
    const std::uint64_t leading = std::bit_cast<std::uint64_t>(value) >> dropped_bits;
    return std::clamp(leading, first_bin, first_bin + bin_count - 1) - first_bin;
}

}  // namespace

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
    if (bins_.empty()) bins_.resize(bin_count);
    ++bins_[bin_of(value)];
    ++total_;
    max_ = std::max(max_, value);
}

void PercentileHistogram::add(const PercentileHistogram& other) {
    if (other.empty()) return;
    bins_.resize(bin_count);
    std::transform(bins_.begin(), bins_.end(), other.bins_.begin(), bins_.begin(), std::plus<>());
    total_ += other.total_;
    max_ = std::max(max_, other.max_);
}

void ValueCounter::add(double value, std::uint32_t count) {
    const auto index = static_cast<std::uint32_t>(bin_of(value));
    std::uint32_t& place = places_[index % places_.size()];
    if (place == 0 || counts_.bins[place - 1].index != index) {
        counts_.bins.push_back({index, 0});
        place = static_cast<std::uint32_t>(counts_.bins.size());
    }
    counts_.bins[place - 1].count += count;
    counts_.max = std::max(counts_.max, value);
}

ValueCounts ValueCounter::take() {
    places_.fill(0);
    return std::exchange(counts_, {});
}

void PercentileHistogram::add(const ValueCounts& counts) {
    if (counts.bins.empty()) return;
    bins_.resize(bin_count);
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
    for (std::uint64_t counted = bins_[0]; counted < rank; counted += bins_[++bin]) {}
    return bin == 0 ? 0 : std::min(max_, std::bit_cast<double>((first_bin + bin + 1) << dropped_bits));
}

Percentiles PercentileHistogram::percentiles() const {
    if (empty()) return percentiles_of({});
    return {quantile(0.5), quantile(0.9), quantile(0.99), max_};
}

}  // namespace kagero
