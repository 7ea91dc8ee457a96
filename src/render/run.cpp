#include "render/run.h"

#include "kernels/assertion.h"
#include "render/threads.h"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>

#include <pmmintrin.h>
#include <time.h>
#include <x86intrin.h>

namespace kagero {
namespace {

/// What one thread gathers; on cache lines of its own.
struct alignas(64) Share {
    RayList list;
    std::vector<RayEnd> ends;
    Counters counters{};
    ThreadTime time;
    std::uint64_t rays = 0;
    Tally energy_errors;
};

/// Numbers too small to matter are zero for this thread while it traces: denormal arithmetic is a hundred times slower.
class FlushDenormals {
public:
    FlushDenormals() : before_(_mm_getcsr()) {
        _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
        _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
    }
    ~FlushDenormals() { _mm_setcsr(before_); }
    FlushDenormals(const FlushDenormals&) = delete;
    FlushDenormals& operator=(const FlushDenormals&) = delete;

private:
    unsigned before_;
};

double processor_seconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

/// An operation on each of the numbers of two counters.
template <class Operation>
Counters each(const Counters& a, const Counters& b, Operation operation) {
    using Numbers = std::array<std::uint64_t, sizeof(Counters) / sizeof(std::uint64_t)>;
    Numbers left = std::bit_cast<Numbers>(a);
    const Numbers right = std::bit_cast<Numbers>(b);
    std::transform(left.begin(), left.end(), right.begin(), left.begin(), operation);
    return std::bit_cast<Counters>(left);
}

RunReport gather(std::vector<Share>& shares) {
    RunReport report;
    Tally energy_errors;
    for (Share& share : shares) {
        report.rays += share.rays;
        report.counters = each(report.counters, share.counters, std::plus{});
        report.threads.push_back(share.time);
        energy_errors.add(share.energy_errors);
    }
    report.energy_error = energy_errors.spread();
    return report;
}

/// A list of tiles being worked on.
class Run {
public:
    Run(const Plan& plan, const Job& job, const WorkList& work, const TileRays& rays, const TileDone& done,
        const Watch& watch)
        : plan_(plan), job_(job), work_(work), rays_(rays), done_(done), watch_(watch) {
        for (std::size_t i = 0; i < work.tiles.size(); ++i) all_ += cost(i);
        if (watch.recording) watch.recording->tiles.assign(work.tiles.size(), TileRecord{});
    }

    /// Works on tiles, as thread number `thread`, until there are none. Where one cannot go on, no other need.
    void work(unsigned thread, Share& share) try {
        for (std::size_t i = next_++; i < work_.tiles.size() && !halted(); i = next_++) {
            const double begin = seconds();
            if (!work_on(i, thread, share)) return;
            share.time.finished = seconds();
            share.time.busy += share.time.finished - begin;
            ++share.time.tiles;
            ++finished_;
            report(cost(i));
        }
    } catch (...) {
        next_ = work_.tiles.size();
        throw;
    }
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }
    bool complete() const { return finished_ == work_.tiles.size(); }
    bool out_of_time() const { return out_of_time_ && !complete(); }

private:
    /// Clocks within a tile's tracing cost a few hundredths of it: a sample of the tiles tells as much.
    static constexpr std::size_t looked_into_every = 4;

    /// How long tiles that are being traced may go on after the end has been called, in seconds: a share of a short
    /// limit.
    double grace() const { return std::min(0.5, 0.5 * watch_.time_limit); }

    /// What a kernel asks while it is busy with a tile.
    struct HaltedTile {
        Run& run;
        bool told = false;
        bool ask() { return told = told || (run.halted() && run.seconds() > run.halted_at_ + run.grace()); }
    };

    double cost(std::size_t i) const { return work_.costs.empty() ? 1 : work_.costs[i]; }

    bool halted() {
        const double now = seconds();
        if (now > watch_.time_limit) out_of_time_ = true;
        if (!out_of_time_ && !(watch_.stop && watch_.stop->load(std::memory_order_relaxed))) return false;
        for (double at = halted_at_; now < at && !halted_at_.compare_exchange_weak(at, now);) {}
        return true;
    }
    /// False where the tile was given up.
    bool work_on(std::size_t i, unsigned thread, Share& share) {
        if (!watch_.recording) return trace(work_.tiles[i], share, nullptr);
        TileRecord& record = watch_.recording->tiles[i];
        const Counters before = share.counters;
        const double processor = processor_seconds();
        record.tile = work_.tiles[i], record.thread = thread, record.predicted = cost(i);
        record.looked_into = (i + watch_.recording->round) % looked_into_every == 0;
        // Asking for processor time enters the system, which may give the processor to another program: not between
        // these two.
        record.begin = seconds();
        const bool done = trace(work_.tiles[i], share, &record);
        record.end = done ? seconds() : 0;
        record.processor = processor_seconds() - processor;
        record.counters = each(share.counters, before, std::minus{});
        return done;
    }
    bool trace(const Tile& tile, Share& share, TileRecord* record) {
        const Counters before = share.counters;
        HaltedTile halting{*this};
        if (rays_) rays_(tile, share.list);
        if (record) record->listed = rays_ ? seconds() : record->begin, record->ticks = __rdtsc();
        Job job = job_;
        job.timed = record && record->looked_into;
        const Halt halt{[](void* user) { return static_cast<HaltedTile*>(user)->ask(); }, &halting};
        halt.tell(job);
        trace_tile(*plan_.run.kernel, job, tile, share.list, share.ends, share.counters);
        if (record) record->traced = seconds(), record->ticks = __rdtsc() - record->ticks;
        if (!halting.told) done_(tile, share.ends.data(), share.list, halt);
        if (halting.told) return share.counters = before, false;
        count(share);
        return true;
    }
    void count(Share& share) const {
        share.rays += share.ends.size();
        if (!(job_.outputs & output_energy)) return;
        for (const RayEnd& end : share.ends)  // of a ray that could not start it is no number
            if (!std::isnan(end.energy_error)) share.energy_errors.add(end.energy_error);
    }
    void report(double cost) {
        const double finished = worth_ += cost;
        if (!watch_.progress) return;
        if (const std::unique_lock lock(reporting_, std::try_to_lock); lock)
            watch_.progress(std::min(finished / all_, 1.0), seconds());
    }

    const Plan& plan_;
    Job job_;
    const WorkList& work_;
    const TileRays& rays_;
    const TileDone& done_;
    const Watch& watch_;
    const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    double all_ = 0;                 ///< cost of all tiles
    std::atomic<double> worth_ = 0;  ///< … and of those that are finished
    std::atomic<std::size_t> next_ = 0, finished_ = 0;
    std::atomic<bool> out_of_time_ = false;
    std::atomic<double> halted_at_ = std::numeric_limits<double>::infinity();
    std::mutex reporting_;
};

}  // namespace

std::size_t rays_of(const Tile& tile, const RayList& list) {
    return list.starts.empty() ? std::size_t(tile.x1 - tile.x0) * (tile.y1 - tile.y0) : list.starts.size();
}

void trace_tile(const KernelInfo& kernel, Job job, const Tile& tile, const RayList& list, std::vector<RayEnd>& ends,
                Counters& counters) {
    const FlushDenormals flush;
    KAGERO_ASSERT(list.starts.empty() ? (job.camera || job.rays)
                                      : (list.frequencies.empty() || list.frequencies.size() == list.starts.size()));
    ends.resize(rays_of(tile, list));
    if (list.starts.empty()) return kernel.trace(&job, &tile, ends.data(), &counters);
    job.camera = nullptr, job.rays = list.starts.data();
    const Tile all{0, 0, static_cast<std::uint32_t>(list.starts.size()), 1};
    kernel.trace(&job, &all, ends.data(), &counters);
}

RunReport run_tiles(const Plan& plan, const Job& job, const WorkList& work, const TileRays& rays, const TileDone& done,
                    const Watch& watch) {
    std::vector<Share> shares(std::max(plan.run.threads, 1u));
    Run run(plan, job, work, rays, done, watch);
    on_threads(static_cast<unsigned>(shares.size()), [&](unsigned thread) { run.work(thread, shares[thread]); });
    const double elapsed = run.seconds();
    RunReport report = gather(shares);
    report.seconds = elapsed;
    report.interrupted = !run.complete();
    report.out_of_time = run.out_of_time();
    return report;
}

}  // namespace kagero
