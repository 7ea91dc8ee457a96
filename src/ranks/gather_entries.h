/// Work that consists of numbered entries, by all ranks.
#pragma once

#include "ranks/rank_link.h"
#include "render/run_report.h"

#include <optional>

namespace kagero {

/// Work that consists of numbered entries. All ranks must give an entry the same content.
struct EntryWork {
    /// Returns the content of an entry; nothing if `stop` was set before it was complete.
    std::function<std::optional<std::string>(std::uint64_t entry, const std::atomic<bool>* stop)> compute;
    /// Rank 0: receives the content of each entry. Called by one thread at a time.
    std::function<void(std::uint64_t entry, const std::string& content)> keep;
    Progress progress = {};  ///< Rank 0: receives the finished share of all entries.
};

/// Computes the entries with the given numbers, which must be the same on all ranks. They are dealt out one by one. If
/// `stop` is set on any rank, all ranks end early. For the exceptions, see JointWork::run.
void compute_on_ranks(Communicator& ranks, const std::vector<std::uint64_t>& entries, const EntryWork& work,
                      const std::atomic<bool>* stop, LinkTimes times = {});

/// Collective: sends bytes from rank 0 to the other ranks, and returns them on all ranks.
std::string share_bytes(Communicator& ranks, std::string bytes);

}  // namespace kagero
