/// The results of finished tiles.
#pragma once

#include "render/run_report.h"

#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace kagero {

/// Collects the results of tiles from several threads: their numbers in the grid, the sums of their reports, and, for a
/// part, their records.
class TileResults {
public:
    /// The records are kept until the part is written.
    enum class Records { kept, dropped };

    explicit TileResults(Records records = Records::dropped) : keeps_records_(records == Records::kept) {}

    /// Returns false, and changes nothing, if the tile was already added. `record` is what encode_tile returns.
    bool add(std::uint64_t index, TileReport report, std::string record = {});
    bool has(std::uint64_t index) const;
    std::uint64_t count() const;
    bool keeps_records() const { return keeps_records_; }
    /// Returns the sums over all tiles. Not to be called while tiles are added.
    const RunTotals& totals() const {
        add_recent();
        return totals_;
    }
    /// Returns the numbers of all tiles in ascending order. Not to be called while tiles are added.
    std::vector<std::uint64_t> tiles() const;
    /// Returns the records by the numbers of their tiles. Not to be called while tiles are added.
    const std::map<std::uint64_t, std::string>& records() const { return records_; }

private:
    void add_recent() const;

    bool keeps_records_;
    std::vector<bool> has_;  ///< By the number of the tile; tiles beyond the last element were not added.
    std::uint64_t count_ = 0;
    /// Reports that are not in the sums yet. Several are added at a time, so that the histograms stay in the cache of
    /// one processor meanwhile.
    mutable std::vector<TileReport> recent_;
    mutable RunTotals totals_;
    std::map<std::uint64_t, std::string> records_;  ///< Empty unless `keeps_records_`.
    mutable std::mutex adding_;
};

}  // namespace kagero
