#include "ranks/gather_entries.h"

#include "parts/bytes.h"
#include "ranks/agreement.h"
#include "ranks/joint_work.h"

#include <chrono>

namespace kagero {

void compute_on_ranks(Communicator& ranks, const std::vector<std::uint64_t>& entries, const EntryWork& work,
                      const std::atomic<bool>* stop, LinkTimes times) {
    const auto begin = std::chrono::steady_clock::now();
    const bool is_root = ranks.rank() == 0;
    std::atomic<std::uint64_t> kept = 0;
    std::mutex keeping;
    const auto keep = [&](std::uint64_t entry, const std::string& content) {
        const std::lock_guard lock(keeping);
        work.keep(entry, content);
        ++kept;
    };
    JointWork joint(ranks, stop, times);
    joint.receive_result = [&](int, std::string_view result) {
        ByteReader reader(result);
        const auto entry = reader.get<std::uint64_t>();
        keep(entry, reader.get_text());
    };
    joint.observe = [&] {
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
        if (work.progress && !entries.empty()) work.progress(double(kept) / double(entries.size()), seconds.count());
    };
    const auto count = static_cast<std::size_t>(ranks.size());
    joint.run([&]() -> std::string {
        for (auto i = static_cast<std::size_t>(ranks.rank()); i < entries.size() && !*joint.stop(); i += count) {
            const std::optional<std::string> content = work.compute(entries[i], joint.stop());
            if (!content) break;
            if (is_root) {
                keep(entries[i], *content);
                continue;
            }
            ByteWriter writer;
            writer.put(entries[i]);
            writer.put_text(*content);
            joint.post_result(writer.bytes);
        }
        return "";
    });
}

std::string share_bytes(Communicator& ranks, std::string bytes) {
    agree(ranks);
    ranks.broadcast(bytes);
    return bytes;
}

}  // namespace kagero
