/// Ranks that are threads of the test, so that failures of ranks and of their messages can be tested without MPI.
#pragma once

#include "ranks/communicator.h"

#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <thread>

namespace kagero::test {

/// The messages of all ranks in one process.
struct LocalMessages {
    explicit LocalMessages(int count) : inboxes(static_cast<std::size_t>(count)) {}

    std::mutex mutex;
    std::condition_variable changed;
    std::vector<std::deque<RankMessage>> inboxes;
    std::map<int, std::string> gathered;  ///< The texts of a gather in progress, by rank.
    std::string broadcast_text;
    int broadcasts = 0;         ///< Number of broadcasts of rank 0.
    int broadcast_readers = 0;  ///< Number of ranks that must still read the text.
    int ended_with = -1;        ///< The status of end_all_ranks.
};

/// One of several ranks in one process.
class LocalCommunicator final : public Communicator {
public:
    LocalCommunicator(LocalMessages& messages, int rank) : messages_(messages) {
        rank_ = rank;
        size_ = static_cast<int>(messages.inboxes.size());
        host_ = "host-" + std::to_string(rank);
    }
    void send(int to, int kind, std::string bytes) override {
        const std::lock_guard lock(messages_.mutex);
        messages_.inboxes[static_cast<std::size_t>(to)].push_back({rank_, kind, std::move(bytes)});
    }
    std::optional<RankMessage> receive() override {
        const std::lock_guard lock(messages_.mutex);
        auto& inbox = messages_.inboxes[static_cast<std::size_t>(rank_)];
        if (inbox.empty()) return {};
        RankMessage message = std::move(inbox.front());
        inbox.pop_front();
        return message;
    }
    std::size_t unsent() override { return 0; }
    void broadcast(std::string& bytes) override {
        std::unique_lock lock(messages_.mutex);
        if (rank_ == 0) {
            messages_.broadcast_text = bytes;
            messages_.broadcast_readers = size_ - 1;
            ++messages_.broadcasts;
            messages_.changed.notify_all();
            messages_.changed.wait(lock, [&] { return messages_.broadcast_readers == 0; });
            return;
        }
        messages_.changed.wait(lock, [&] { return messages_.broadcasts > broadcasts_; });
        ++broadcasts_;
        bytes = messages_.broadcast_text;
        --messages_.broadcast_readers;
        messages_.changed.notify_all();
    }
    std::vector<std::string> gather(const std::string& bytes) override {
        std::unique_lock lock(messages_.mutex);
        messages_.changed.wait(lock, [&] { return !messages_.gathered.contains(rank_); });
        messages_.gathered[rank_] = bytes;
        messages_.changed.notify_all();
        if (rank_ > 0) return {};
        messages_.changed.wait(lock, [&] { return messages_.gathered.size() == messages_.inboxes.size(); });
        std::vector<std::string> texts;
        for (const auto& [rank, text] : messages_.gathered) texts.push_back(text);
        messages_.gathered.clear();
        messages_.changed.notify_all();
        return texts;
    }
    void end_all_ranks(int status) override { messages_.ended_with = status; }

private:
    LocalMessages& messages_;
    int broadcasts_ = 0;  ///< Number of broadcasts that this rank has read.
};

/// Calls `work` on `count` ranks, each in a thread of its own. Returns the failures of the ranks: the message of the
/// exception, or an empty text.
inline std::vector<std::string> run_ranks(int count, const std::function<void(Communicator&)>& work,
                                          const std::function<std::string()>& failure_text) {
    LocalMessages messages(count);
    std::vector<std::string> failures(static_cast<std::size_t>(count));
    std::vector<std::jthread> threads;
    for (int rank = 0; rank < count; ++rank)
        threads.emplace_back([&, rank] {
            LocalCommunicator ranks(messages, rank);
            try {
                work(ranks);
            } catch (...) {
                failures[static_cast<std::size_t>(rank)] = failure_text();
            }
        });
    threads.clear();
    return failures;
}

}  // namespace kagero::test
