#include "library/ray_arrays.h"

#include "large_vector.h"
#include "render/threads.h"

#include <algorithm>
#include <atomic>
#include <mutex>

namespace kagero {

namespace {

/// Number of rays in a batch. Longer lists would take long to get their memory from the system; in shorter ones, rays
/// that are traced together would be less similar.
constexpr std::size_t rays_per_batch = 1 << 18;

/// Writes the starts of rays first … first + starts.size() − 1.
void write_starts_by_threads(const Plan& plan, const RayArrays& rays, std::optional<ObserverKind> observer,
                             std::size_t first, std::vector<RayStart>& starts) {
    constexpr std::size_t chunk = 4096;  // rays
    const std::size_t chunks = (starts.size() + chunk - 1) / chunk;
    std::atomic<std::size_t> next = 0;
    run_on_threads(static_cast<unsigned>(std::clamp<std::size_t>(chunks, 1, plan.run.threads)), [&](unsigned) {
        for (std::size_t i = next++; i < chunks; i = next++) {
            const std::size_t begin = i * chunk, end = std::min(begin + chunk, starts.size());
            write_starts(plan, rays, observer, first + begin, first + end, starts.data() + begin);
        }
    });
}

/// Adds the times of a batch to a report.
void add_times(const RunReport& batch, RunReport& report) {
    report.seconds += batch.seconds;
    report.interrupted = report.interrupted || batch.interrupted;
    report.threads.resize(std::max(report.threads.size(), batch.threads.size()));
    for (std::size_t i = 0; i < batch.threads.size(); ++i) {
        report.threads[i].busy += batch.threads[i].busy;
        report.threads[i].finished += batch.threads[i].finished;
        report.threads[i].tiles += batch.threads[i].tiles;
    }
}

}  // namespace

std::vector<RayStart> start_arrays(const Plan& plan, const RayArrays& rays, std::optional<ObserverKind> observer) {
    std::vector<RayStart> starts = large_vector<RayStart>(rays.count, plan.run.threads);
    write_starts_by_threads(plan, rays, observer, 0, starts);
    return starts;
}

RunReport trace_arrays(const Plan& plan, const RayArrays& rays, std::optional<ObserverKind> observer, bool with_paths,
                       const RunControl& control, const TakeEnds& take) {
    std::vector<RayStart> starts = large_vector<RayStart>(std::min(rays.count, rays_per_batch), plan.run.threads);
    std::vector<RayEnd> ends;
    std::vector<PathState> paths;
    RunTotals totals;
    std::mutex totals_mutex;
    RunReport report;
    for (std::size_t first = 0; first == 0 || first < rays.count; first += rays_per_batch) {
        starts.resize(std::min(rays.count - first, rays_per_batch));
        write_starts_by_threads(plan, rays, observer, first, starts);
        RunControl of_batch = control;
        of_batch.tile_finished = [&](const Tile&, const TileReport& tile) {
            const std::lock_guard lock(totals_mutex);
            totals.add(tile);
        };
        if (control.progress)
            of_batch.progress = [&](double done, double seconds) {
                control.progress((double(first) + done * double(starts.size())) / double(rays.count),
                                 report.seconds + seconds);
            };
        add_times(trace(plan, starts, ends, of_batch, with_paths ? &paths : nullptr), report);
        take(ends, paths, first);
    }
    totals.write_to(report);
    return report;
}

}  // namespace kagero
