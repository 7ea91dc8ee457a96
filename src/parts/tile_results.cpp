#include "parts/tile_results.h"

namespace kagero {
namespace {

/// Number of reports that are added to the sums at a time.
constexpr std::size_t reports_per_sum = 32;

}  // namespace

void TileResults::add_recent() const {
    for (const TileReport& report : recent_) totals_.add(report);
    recent_.clear();
}

bool TileResults::add(std::uint64_t index, TileReport report, std::string record) {
    const std::lock_guard lock(adding_);
    if (index < has_.size() && has_[index]) return false;
    if (index >= has_.size()) has_.resize(index + 1);
    has_[index] = true;
    ++count_;
    recent_.push_back(std::move(report));
    if (recent_.size() == reports_per_sum) add_recent();
    if (keeps_records_) records_.emplace(index, std::move(record));
    return true;
}

bool TileResults::has(std::uint64_t index) const {
    const std::lock_guard lock(adding_);
    return index < has_.size() && has_[index];
}

std::uint64_t TileResults::count() const {
    const std::lock_guard lock(adding_);
    return count_;
}

std::vector<std::uint64_t> TileResults::tiles() const {
    std::vector<std::uint64_t> tiles;
    for (std::uint64_t index = 0; index < has_.size(); ++index)
        if (has_[index]) tiles.push_back(index);
    return tiles;
}

}  // namespace kagero
