#include "ranks/gather_tiles.h"

#include "accuracy/end_errors.h"
#include "error.h"
#include "parts/bytes.h"

#include <algorithm>

namespace kagero {
namespace {

/// Kinds of messages. Kind 0 belongs to the link.
enum MessageKind : int {
    tile_message = 1,  ///< To rank 0: the record of a finished tile.
    stop_message,      ///< All ranks end early.
    end_message,       ///< To rank 0: the sender renders no more tiles; see RankEnd.
    over_message       ///< From rank 0: all ranks have ended.
};

/// The state in which the work of a rank ended.
struct RankEnd {
    RankTime time;
    std::vector<ThreadTime> threads;
    bool out_of_time = false;
    std::string failure;  ///< Reason why the rank failed; empty if it did not.
};

std::string encode(const RankEnd& end) {
    ByteWriter writer;
    writer.put_text(end.time.host);
    writer.put(end.time.threads);
    writer.put(end.time.tiles);
    writer.put(end.time.seconds);
    writer.put(end.time.busy);
    writer.put(std::uint64_t{end.threads.size()});
    for (const ThreadTime& thread : end.threads) writer.put(thread);
    writer.put(static_cast<std::uint8_t>(end.out_of_time));
    writer.put_text(end.failure);
    return writer.bytes;
}

RankEnd decode_end(const std::string& bytes) {
    ByteReader reader(bytes);
    RankEnd end;
    end.time.host = reader.get_text();
    end.time.threads = reader.get<std::uint32_t>();
    end.time.tiles = reader.get<std::uint64_t>();
    end.time.seconds = reader.get<double>();
    end.time.busy = reader.get<double>();
    for (auto left = reader.get<std::uint64_t>(); left > 0; --left) end.threads.push_back(reader.get<ThreadTime>());
    end.out_of_time = reader.get<std::uint8_t>() != 0;
    end.failure = reader.get_text();
    return end;
}

RankEnd end_of(const RunReport& report, const std::string& host) {
    RankEnd end{{host, static_cast<std::uint32_t>(report.threads.size()), 0, 0, 0}, report.threads, report.out_of_time,
                ""};
    for (const ThreadTime& thread : report.threads) {
        end.time.tiles += thread.tiles;
        end.time.busy += thread.busy;
        end.time.seconds = std::max(end.time.seconds, thread.finished);
    }
    return end;
}

/// Returns, for each tile of the grid, whether this rank renders it.
std::vector<bool> tiles_of_rank(const Communicator& ranks, const TileFileHeader& header, const TileResults& results) {
    std::vector<bool> own(header.grid.count());
    std::uint64_t next = 0;  // number of the next tile that is dealt out
    const auto count = static_cast<std::uint64_t>(ranks.size());
    for (std::uint64_t index = 0; index < own.size(); ++index)
        if (header.part.contains(index) && !results.has(index))
            own[index] = next++ % count == static_cast<std::uint64_t>(ranks.rank());
    return own;
}

/// The part of a rank that all ranks have in common: the render of its own tiles, and the flag that ends it.
class RankRender {
public:
    RankRender(Communicator& ranks, const Plan& plan, const TileFileHeader& header, Film& film,
               const TileResults& results, RunControl control)
        : ranks_(ranks), plan_(plan), header_(header), film_(film), own_(tiles_of_rank(ranks, header, results)),
          caller_stop_(control.stop), control_(std::move(control)) {
        control_.stop = &stop_;
        control_.selects_tile = [this](const Tile& tile) { return own_[header_.grid.index_of(tile)]; };
    }

    /// Renders the tiles of this rank. An exception is returned as a failure, and kept for rethrow().
    RunReport render(RankEnd& end, const TileFinished& tile_finished) {
        control_.tile_finished = tile_finished;
        RunReport report;
        try {
            report = render_with_errors(plan_, film_, control_);
            end = end_of(report, ranks_.host());
        } catch (const std::exception& error) {
            failure_ = std::current_exception();
            end = {{ranks_.host(), 0, 0, 0, 0}, {}, false, error.what()};
        }
        return report;
    }
    void rethrow() const {
        if (failure_) std::rethrow_exception(failure_);
    }

    void stop() { stop_ = true; }
    /// Returns true once, when the run has been stopped on this rank or by a message.
    bool must_announce_stop() {
        if (caller_stop_ && *caller_stop_) stop_ = true;
        return stop_ && !announced_.exchange(true);
    }
    /// Stops this rank because of a message, which is not announced to its sender.
    void stop_as_announced() {
        announced_ = true;
        stop_ = true;
    }
    std::string record_of(const Tile& tile, const TileReport& report) const {
        return encode_tile(header_, header_.grid.index_of(tile), report, film_);
    }
    const RunControl& control() const { return control_; }

private:
    Communicator& ranks_;
    const Plan& plan_;
    const TileFileHeader& header_;
    Film& film_;
    const std::vector<bool> own_;
    const std::atomic<bool>* caller_stop_;
    std::atomic<bool> stop_ = false, announced_ = false;
    RunControl control_;
    std::exception_ptr failure_;
};

/// The work of rank 0: it renders its tiles, and receives those of the others.
class Root {
public:
    Root(Communicator& ranks, const Plan& plan, const TileFileHeader& header, Film& film, TileResults& results,
         Journal* journal, RunControl control, LinkTimes times)
        : header_(header), film_(film), results_(results), journal_(journal),
          earlier_tiles_(results.count()), earlier_rays_(results.totals().sums.rays), ends_(std::size_t(ranks.size())),
          progress_(std::move(control.progress)), render_(ranks, plan, header, film, results, with_lock(control)),
          link_(ranks, [this](const RankMessage& message) { receive(message); }, [this] { idle(); }, times) {}

    RunReport run() {
        link_.start([this] { render_.stop(); });
        RunReport report = render_.render(ends_[0], [this](const Tile& tile, const TileReport& tile_report) {
            if (journal_) journal_->append(render_.record_of(tile, tile_report));
            results_.add(header_.grid.index_of(tile), tile_report);
        });
        if (!ends_[0].failure.empty()) render_.stop();
        rendered_ = true;
        join();
        render_.rethrow();
        if (failure_) std::rethrow_exception(failure_);
        refuse_failures();
        complete(report);
        return report;
    }

private:
    RunControl with_lock(RunControl control) {
        control.progress = {};
        control.film_mutex = &film_mutex_;
        return control;
    }

    double seconds() const {
        return std::chrono::duration<double>(RankLink::Clock::now() - begin_).count();
    }

    /// Waits until all ranks have ended. The journal is complete even if a rank is lost.
    void join() {
        try {
            link_.join();
        } catch (...) {
            if (journal_) journal_->sync();
            throw;
        }
    }

    /// Handles a message. A failure, such as a full disk, stops all ranks and is thrown when they have ended.
    void receive(const RankMessage& message) {
        try {
            if (message.kind == tile_message) add_tile(message);
            else if (message.kind == end_message) add_end(message);
            else render_.stop();
        } catch (const std::exception&) {
            if (!failure_) failure_ = std::current_exception();
            render_.stop();
        }
    }

    void add_end(const RankMessage& message) {
        RankEnd& end = ends_[std::size_t(message.from)];
        end = decode_end(message.bytes);
        ++ended_;
        if (!end.failure.empty()) render_.stop();
    }

    void add_tile(const RankMessage& message) {
        bool added = false;
        {
            const std::shared_lock lock(film_mutex_);
            added = add_tile_record(header_, message.bytes, film_, results_);
        }
        if (!added) throw RunError("rank " + std::to_string(message.from) + " has sent a tile that is not expected");
        if (journal_) journal_->append(message.bytes);
    }

    void idle() {
        if (render_.must_announce_stop()) link_.post_to_all(stop_message, "");
        const auto done = double(results_.count() - earlier_tiles_),
                   all = double(header_.part.tiles_of(header_.grid) - earlier_tiles_);
        if (progress_ && all > 0) progress_(done / all, seconds());
        if (!rendered_) return;
        const RunControl& control = render_.control();
        if (control.snapshot_requested && control.snapshot_requested->exchange(false)) control.snapshot(&film_);
        if (ended_ + 1 < ends_.size() || is_over_) return;
        is_over_ = true;
        link_.post_to_all(over_message, "");
        link_.finish();
    }

    /// Throws RunError if another rank failed.
    void refuse_failures() const {
        for (std::size_t rank = 1; rank < ends_.size(); ++rank)
            if (!ends_[rank].failure.empty())
                throw RunError("rank " + std::to_string(rank) + " on host " + ends_[rank].time.host + ": " +
                               ends_[rank].failure);
    }

    void complete(RunReport& report) {
        report.threads.clear();
        report.out_of_time = false;
        for (const RankEnd& end : ends_) {
            report.threads.insert(report.threads.end(), end.threads.begin(), end.threads.end());
            report.ranks.push_back(end.time);
            report.out_of_time = report.out_of_time || end.out_of_time;
        }
        results_.totals().write_to(report);
        report.earlier_rays = earlier_rays_;
        report.interrupted = results_.count() < header_.part.tiles_of(header_.grid);
        report.out_of_time = report.out_of_time && report.interrupted;
        if (journal_ && report.interrupted) journal_->sync();
        report.seconds = seconds();
    }

    const TileFileHeader& header_;
    Film& film_;
    TileResults& results_;
    Journal* const journal_;
    const RankLink::Clock::time_point begin_ = RankLink::Clock::now();
    const std::uint64_t earlier_tiles_, earlier_rays_;
    std::vector<RankEnd> ends_;     ///< Those of the other ranks belong to the thread of the link until it has ended.
    std::size_t ended_ = 0;         ///< Number of other ranks that have ended.
    bool is_over_ = false;
    std::exception_ptr failure_;    ///< First failure in the thread of the link.
    std::atomic<bool> rendered_ = false;  ///< True when the own tiles are finished.
    std::shared_mutex film_mutex_;
    const Progress progress_;
    RankRender render_;
    RankLink link_;  ///< The last member, because its thread uses the others.
};

/// The work of another rank: it sends its tiles to rank 0.
class Worker {
public:
    Worker(Communicator& ranks, const Plan& plan, const TileFileHeader& header, Film& film, const TileResults& results,
           RunControl control, LinkTimes times)
        : render_(ranks, plan, header, film, results, without_outputs(std::move(control))),
          link_(ranks, [this](const RankMessage& message) { receive(message); }, [this] { idle(); }, times) {}

    RunReport run() {
        link_.start([this] { render_.stop(); });
        RankEnd end;
        RunReport report = render_.render(end, [this](const Tile& tile, const TileReport& tile_report) {
            link_.post(0, tile_message, render_.record_of(tile, tile_report));
        });
        link_.post(0, end_message, encode(end));
        link_.join();
        render_.rethrow();
        return report;
    }

private:
    static RunControl without_outputs(RunControl control) {
        control.progress = {};
        control.snapshot_requested = nullptr;
        return control;
    }
    void receive(const RankMessage& message) {
        if (message.kind == over_message) return link_.finish();
        render_.stop_as_announced();
    }
    void idle() {
        if (render_.must_announce_stop()) link_.post(0, stop_message, "");
    }

    RankRender render_;
    RankLink link_;  ///< The last member, because its thread uses the others.
};

}  // namespace

RunReport render_on_ranks(Communicator& ranks, const Plan& plan, const TileFileHeader& header, Film& film,
                          TileResults& results, Journal* journal, const RunControl& control, LinkTimes times) {
    if (ranks.rank() == 0) return Root(ranks, plan, header, film, results, journal, control, times).run();
    return Worker(ranks, plan, header, film, results, control, times).run();
}

}  // namespace kagero
