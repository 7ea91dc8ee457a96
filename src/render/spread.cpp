#include "render/spread.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>

namespace kagero {
namespace {

// Bins of a tally are the leading bits of doubles: the exponents from −128 to 127, eight bits of the fraction.
constexpr int fraction_bits = 8, dropped_bits = 52 - fraction_bits;
constexpr std::uint64_t bin_count = std::uint64_t(256) << fraction_bits, first_bin = std::uint64_t(1023 - 128)
                                                                                     << fraction_bits;

std::uint64_t bin_of(double value) {
    const std::uint64_t leading = std::bit_cast<std::uint64_t>(value) >> dropped_bits;
    return std::clamp(leading, first_bin, first_bin + bin_count - 1) - first_bin;
}

}  // namespace

Spread spread_of(std::vector<double> values) {
    constexpr double not_known = std::numeric_limits<double>::quiet_NaN();
    if (values.empty()) return {not_known, not_known, not_known, not_known};
    auto rest = values.begin();  // where none is less than those before
    const auto at = [&](double share) {
        const auto place =
            values.begin() + static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(values.size()))) - 1;
        std::nth_element(rest, place, values.end());
        return *(rest = place);
    };
    return {at(0.5), at(0.9), at(0.99), at(1.0)};
}

void Tally::add(double value) {
    if (bins_.empty()) bins_.resize(bin_count);
    ++bins_[bin_of(value)], ++total_;
    max_ = std::max(max_, value);
}

void Tally::add(const Tally& other) {
    if (other.empty()) return;
    bins_.resize(bin_count);
    std::transform(bins_.begin(), bins_.end(), other.bins_.begin(), bins_.begin(), std::plus<>());
    total_ += other.total_, max_ = std::max(max_, other.max_);
}

/// The upper end of the bin of that rank.
double Tally::at(double share) const {
    const auto rank = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(total_)));
    std::uint64_t bin = 0;
    for (std::uint64_t passed = bins_[0]; passed < rank; passed += bins_[++bin]) {}
    return bin == 0 ? 0 : std::min(max_, std::bit_cast<double>((first_bin + bin + 1) << dropped_bits));
}

Spread Tally::spread() const {
    if (empty()) return spread_of({});
    return {at(0.5), at(0.9), at(0.99), max_};
}

}  // namespace kagero
