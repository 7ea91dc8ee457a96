#include "parts/tile_results.h"

namespace kagero {

bool TileResults::add(std::uint64_t index, TileReport report) {
    const std::lock_guard lock(adding_);
    return reports_.emplace(index, std::move(report)).second;
}

bool TileResults::has(std::uint64_t index) const {
    const std::lock_guard lock(adding_);
    return reports_.contains(index);
}

std::uint64_t TileResults::count() const {
    const std::lock_guard lock(adding_);
    return reports_.size();
}

RunTotals TileResults::totals() const {
    RunTotals totals;
    for (const auto& [index, report] : reports_) totals.add(report);
    return totals;
}

}  // namespace kagero
