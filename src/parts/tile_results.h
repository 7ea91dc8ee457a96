/// The reports of finished tiles.
#pragma once

#include "render/run_report.h"

#include <map>
#include <mutex>

namespace kagero {

/// Collects the reports of tiles from several threads, by the index of the tile in its grid.
class TileResults {
public:
    /// Returns false, and changes nothing, if there already is a report of the tile.
    bool add(std::uint64_t index, TileReport report);
    bool has(std::uint64_t index) const;
    std::uint64_t count() const;
    /// Returns the sums over all tiles.
    RunTotals totals() const;
    const std::map<std::uint64_t, TileReport>& reports() const { return reports_; }

private:
    std::map<std::uint64_t, TileReport> reports_;
    mutable std::mutex adding_;
};

}  // namespace kagero
