#include "ranks/gather_tiles.h"

#include "accuracy/end_errors.h"
#include "error.h"
#include "parts/bytes.h"
#include "parts/journals/journal_writer.h"
#include "ranks/joint_work.h"
#include "ranks/tile_supply.h"

#include <algorithm>

namespace kagero {
namespace {

/// The measurements of the render of one rank.
struct RankReport {
    RankTime time;
    std::vector<ThreadTime> threads;
    bool out_of_time = false;
};

std::string encode(const RunReport& report, const std::string& host) {
    ByteWriter writer;
    writer.put_text(host);
    writer.put(std::uint64_t{report.threads.size()});
    for (const ThreadTime& thread : report.threads) writer.put(thread);
    writer.put(static_cast<std::uint8_t>(report.out_of_time));
    return writer.bytes;
}

RankReport decode(const std::string& bytes) {
    ByteReader reader(bytes);
    RankReport report;
    report.time.host = reader.get_text();
    report.threads.resize(reader.get<std::uint64_t>());
    report.time.threads = static_cast<std::uint32_t>(report.threads.size());
    for (ThreadTime& thread : report.threads) {
        thread = reader.get<ThreadTime>();
        report.time.tiles += thread.tiles;
        report.time.busy += thread.busy;
        report.time.seconds = std::max(report.time.seconds, thread.finished);
    }
    report.out_of_time = reader.get<std::uint8_t>() != 0;
    return report;
}

/// The tiles of a picture that are not finished. One half is divided before the render; the other half is dealt out
/// while the ranks render, because their speeds may differ.
struct TileDivision {
    std::vector<bool> own;                ///< For each tile of the grid, whether it is this rank's from the beginning.
    std::vector<std::uint64_t> supplied;  ///< The numbers of the tiles that are dealt out later.

    TileDivision(const Communicator& ranks, const TileFileHeader& header, const TileResults& results)
        : own(header.grid.count()) {
        const auto count = static_cast<std::uint64_t>(ranks.size()), rank = static_cast<std::uint64_t>(ranks.rank());
        std::uint64_t next = 0;  // number of the next tile that is dealt out
        for (std::uint64_t index = 0; index < own.size(); ++index) {
            if (!header.part.contains(index) || results.has(index)) continue;
            const std::uint64_t turn = next++;
            if (turn % 2 == 0) own[index] = turn / 2 % count == rank;
            else supplied.push_back(index);
        }
    }
};

/// Makes a run render the tiles of a supply after its own ones.
void add_supply(RunControl& control, TileSupply& supply, const TileGrid& grid, const std::atomic<bool>& stop) {
    supply.request_first();
    control.further_tile = [&supply, &grid, &stop]() -> std::optional<Tile> {
        const std::optional<std::uint64_t> index = supply.next(stop);
        if (!index) return {};
        return grid.tile(*index);
    };
}

/// The render of rank 0: it renders its tiles, and receives those of the others.
class TileGathering {
public:
    TileGathering(Communicator& ranks, const TileFileHeader& header, std::vector<std::uint64_t> supplied, Film& film,
                  TileResults& results, Journal* journal, const RunControl& control, LinkTimes times)
        : header_(header), film_(film), results_(results), control_(control), earlier_tiles_(results.count()),
          earlier_rays_(results.totals().sums.rays), supply_(ranks.size(), std::move(supplied), {}),
          work_(ranks, control.stop, times) {
        if (journal) writer_.emplace(*journal, header, film);
        work_.answer_request = [this](const std::string& request) {
            ByteWriter share;
            share.put_list(supply_.take_share(ByteReader(request).get<std::uint64_t>()));
            if (supply_.is_short()) work_.expect_messages();
            return share.bytes;
        };
        work_.receive_result = [this](int from, std::string_view record) { receive(from, record); };
        work_.observe = [this] { observe(); };
    }

    RunReport run(const Plan& plan, const std::string& host, RunControl own_control) try {
        own_control.stop = work_.stop();
        own_control.progress = {};
        own_control.film_mutex = &film_mutex_;
        add_supply(own_control, supply_, header_.grid, *work_.stop());
        own_control.tile_finished = [this](const Tile& tile, TileReport tile_report) {
            const std::uint64_t index = header_.grid.index_of(tile);
            if (writer_) writer_->add(index, tile_report);
            results_.add(index, std::move(tile_report));
        };
        RunReport report;
        const std::vector<std::string> ends = work_.run([&] {
            report = render_with_errors(plan, film_, own_control);
            return encode(report, host);
        });
        complete(report, ends);
        if (writer_ && report.interrupted) writer_->sync();
        return report;
    } catch (...) {
        if (writer_) writer_->sync();
        throw;
    }

private:
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }
    std::uint64_t tiles() const { return header_.part.tiles_of(header_.grid); }

    void receive(int from, std::string_view record) {
        bool added = false;
        {
            const std::shared_lock lock(film_mutex_);
            added = add_tile_record(header_, record, film_, results_);
        }
        if (!added) throw RunError("rank " + std::to_string(from) + " has sent a tile that is not expected");
        if (writer_) writer_->add(std::string(record));
    }

    /// Shows the progress. Takes a requested snapshot if the threads of this rank have ended; before, they do.
    void observe() {
        if (control_.progress && tiles() > earlier_tiles_)
            control_.progress(double(results_.count() - earlier_tiles_) / double(tiles() - earlier_tiles_), seconds());
        if (!work_.own_work_is_done() || !control_.snapshot_requested) return;
        if (control_.snapshot_requested->exchange(false)) control_.snapshot(&film_);
    }

    /// Replaces the measurements of rank 0 by those of all ranks.
    void complete(RunReport& report, const std::vector<std::string>& ends) const {
        report.seconds = seconds();
        report.threads.clear();
        report.interrupted = results_.count() < tiles();
        report.out_of_time = false;
        for (const std::string& end : ends) {
            const RankReport of_rank = decode(end);
            report.threads.insert(report.threads.end(), of_rank.threads.begin(), of_rank.threads.end());
            report.ranks.push_back(of_rank.time);
            report.out_of_time = report.out_of_time || (of_rank.out_of_time && report.interrupted);
        }
        results_.totals().write_to(report);
        report.earlier_rays = earlier_rays_;
    }

    const TileFileHeader& header_;
    Film& film_;
    TileResults& results_;
    const RunControl& control_;
    const std::uint64_t earlier_tiles_, earlier_rays_;
    const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    std::shared_mutex film_mutex_;
    TileSupply supply_;
    std::optional<JournalWriter> writer_;
    JointWork work_;  ///< The last member, because its thread uses the others.
};

/// Renders the tiles of another rank, and sends them to rank 0.
RunReport render_for_root(Communicator& ranks, const Plan& plan, const TileFileHeader& header, Film& film,
                          RunControl control, LinkTimes times) {
    std::optional<JointWork> work;  // its thread uses the supply
    TileSupply supply(ranks.size(), {}, [&](std::size_t fewest) {
        ByteWriter request;
        request.put(std::uint64_t{fewest});
        work->post_request(request.bytes);
    });
    work.emplace(ranks, control.stop, times);
    work->receive_answer = [&](const std::string& bytes) {
        supply.receive(ByteReader(bytes).get_list<std::uint64_t>());
    };
    add_supply(control, supply, header.grid, *work->stop());
    control.stop = work->stop();
    control.progress = {};
    control.snapshot_requested = nullptr;
    control.tile_film_finished = [&](const Tile& tile, const TileReport& report, const Film& pixels) {
        const std::uint64_t index = header.grid.index_of(tile);
        work->post_result(encode_tile(header, index, report, pixels));
    };
    RunReport report;
    work->run([&] {
        report = render_with_errors(plan, film, control);
        return encode(report, ranks.host());
    });
    return report;
}

}  // namespace

RunReport render_on_ranks(Communicator& ranks, const Plan& plan, const TileFileHeader& header, Film& film,
                          TileResults& results, Journal* journal, const RunControl& control, LinkTimes times) {
    TileDivision tiles(ranks, header, results);
    RunControl own_control = control;
    own_control.selects_tile = [&](const Tile& tile) { return tiles.own[header.grid.index_of(tile)]; };
    if (ranks.rank() > 0) return render_for_root(ranks, plan, header, film, own_control, times);
    return TileGathering(ranks, header, std::move(tiles.supplied), film, results, journal, control, times)
        .run(plan, ranks.host(), own_control);
}

}  // namespace kagero
