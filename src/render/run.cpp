#include "render/run.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <mutex>

#include <xmmintrin.h>
#include <pmmintrin.h>

namespace kagero {
namespace {

/// What one thread gathers.
struct Share {
    RayList list;
    std::vector<RayEnd> ends;
    Counters counters{};
    std::uint64_t rays = 0, unrefined = 0;
    std::uint64_t status[status_count] = {};
    std::vector<double> energy_errors;
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

void trace_list(const Plan& plan, Job job, Share& share) {
    job.camera = nullptr, job.rays = share.list.starts.data();
    const Tile all{0, 0, static_cast<std::uint32_t>(share.list.starts.size()), 1};
    share.ends.resize(share.list.starts.size());
    plan.kernel->trace(&job, &all, share.ends.data(), &share.counters);
}

void trace_one(const Plan& plan, const Job& job, const Tile& tile, const TileRays& rays, Share& share, const TileDone& done) {
    const FlushDenormals flush;
    if (rays) {
        rays(tile, share.list);
        trace_list(plan, job, share);
    } else {
        share.ends.resize(std::size_t(tile.x1 - tile.x0) * (tile.y1 - tile.y0));
        plan.kernel->trace(&job, &tile, share.ends.data(), &share.counters);
    }
    done(tile, share.ends.data(), share.list);
    share.rays += share.ends.size();
    for (const RayEnd& end : share.ends) {
        ++share.status[static_cast<int>(end.status)];
        share.unrefined += end.unrefined;
        if (job.outputs & output_energy) share.energy_errors.push_back(end.energy_error);
    }
}

Counters sum(Counters a, const Counters& b) {
    a.active_lane_steps += b.active_lane_steps, a.issued_lane_steps += b.issued_lane_steps;
    a.active_iterations += b.active_iterations, a.issued_iterations += b.issued_iterations;
    a.steps += b.steps, a.gradients += b.gradients, a.queries += b.queries;
    return a;
}

Percentiles percentiles(std::vector<double>& values) {
    if (values.empty()) return {};
    const auto at = [&](double share) {
        const auto place = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
        std::nth_element(values.begin(), place, values.end());
        return *place;
    };
    return {at(0.5), at(0.99), at(1.0)};
}

RunReport gather(tbb::enumerable_thread_specific<Share>& shares) {
    RunReport report;
    std::vector<double> energy_errors;
    for (Share& share : shares) {
        report.rays += share.rays, report.unrefined += share.unrefined;
        report.counters = sum(report.counters, share.counters);
        for (std::uint32_t i = 0; i < status_count; ++i) report.status[i] += share.status[i];
        energy_errors.insert(energy_errors.end(), share.energy_errors.begin(), share.energy_errors.end());
    }
    report.energy_error = percentiles(energy_errors);
    return report;
}

}  // namespace

RunReport run_tiles(const Plan& plan, const Job& job, const std::vector<Tile>& tiles, const TileRays& rays, const TileDone& done,
                    const Progress& progress, const std::atomic<bool>* stop) {
    const auto begin = std::chrono::steady_clock::now();
    const auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(); };
    tbb::enumerable_thread_specific<Share> shares;
    std::mutex reporting;
    std::atomic<std::size_t> finished = 0;
    const auto one = [&](std::size_t i) {
        if (stop && stop->load(std::memory_order_relaxed)) return;
        trace_one(plan, job, tiles[i], rays, shares.local(), done);
        const std::size_t n = ++finished;
        if (!progress) return;
        if (const std::unique_lock lock(reporting, std::try_to_lock); lock) progress(double(n) / double(tiles.size()), seconds());
    };
    // More threads than cores only if asked for.
    const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, std::max<std::size_t>(plan.threads, 1));
    tbb::task_arena arena(static_cast<int>(plan.threads));
    arena.execute([&] { tbb::parallel_for(std::size_t(0), tiles.size(), one, tbb::simple_partitioner{}); });
    const double elapsed = seconds();
    RunReport report = gather(shares);
    report.seconds = elapsed;
    report.interrupted = finished < tiles.size();
    return report;
}

}  // namespace kagero
