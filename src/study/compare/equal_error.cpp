#include "study/compare/equal_error.h"

#include "accuracy/error_curves.h"
#include "error.h"
#include "render/run.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace kagero {
namespace {

/// Candidates that need more than this multiple of the fewest gradients are not timed.
constexpr double max_relative_gradients = 3;
/// Number of times that each candidate is timed. The runs are interleaved, so that a disturbance of the machine affects
/// all candidates.
constexpr unsigned timed_rounds = 9;
/// From the second round on, candidates that take more than this multiple of the shortest time are dropped.
constexpr double max_relative_time = 1.5;

/// A candidate with its measured time.
struct TimedVariant {
    Variant variant;
    double gradients;
    double min_seconds = std::numeric_limits<double>::infinity();  ///< Shortest time of a run.
};

/// Returns tiles with about 32768 rays in total, from all parts of the picture. Whole tiles are sampled because the
/// time of a packet and of its queries depends on neighbouring rays.
WorkList sample_of(const Plan& plan) {
    constexpr std::size_t sample_rays = 32768;
    const WorkList all = split_into_tiles(plan, plan.view.window, Schedule::tiles);
    const double all_rays = std::accumulate(all.costs.begin(), all.costs.end(), 0.0);  // A cost is a number of rays.
    // The interval is odd. An even interval could divide the number of tiles in a row, and the sample would then
    // contain only a few columns of tiles.
    const std::size_t interval = static_cast<std::size_t>(all_rays / sample_rays) | 1;
    WorkList sample;
    for (std::size_t i = 0; i < all.tiles.size(); i += interval) {
        sample.tiles.push_back(all.tiles[i]);
        sample.costs.push_back(all.costs[i]);
    }
    return sample;
}

/// Returns the time in seconds to trace the sample with a variant.
double seconds_of(const Plan& base, const Variant& variant) {
    const Plan plan = plan_with_variant(base, variant);
    const Job job = plan.medium(plan.view.medium).job();
    TileRays rays;
    if (!job.camera) rays = [&](const Tile& tile, RayList& list) { list_rays(plan, tile, list); };
    const auto ignore_ends = [](const Tile&, const TracedRays&, const CancelToken&) {};
    return run_tiles(plan, job, sample_of(plan), rays, ignore_ends).seconds;
}

}  // namespace

Candidates find_candidates(const Plan& plan, double pixels, const std::atomic<bool>* stop) {
    CurveOptions options;
    options.pixel_bound = pixels;
    const ErrorCurves study = measure_curves(plan, options, {}, stop);
    if (!is_confirmed(study.reference)) throw RunError("--equal-error: " + describe_disagreement(study.reference));
    Candidates candidates;
    for (const StudyCurve& curve : study.curves) {
        const StudyPoint* best = nullptr;
        for (const StudyPoint& point : curve.points)
            if (is_within(point, pixels, &RayErrors::pixels, study.reference) &&
                (!best || point.gradients < best->gradients))
                best = &point;
        if (!best) continue;
        const double solver_tolerance = curve.has_loose_solver ? best->solver_tolerance : -1;
        candidates.push_back({curve.method, curve.precision, best->step, solver_tolerance, best->gradients});
    }
    return candidates;
}

std::optional<Variant> cheapest_for(const Plan& plan, const KernelInfo& kernel, const Candidates& candidates,
                                    const std::atomic<bool>* stop) {
    std::vector<TimedVariant> timed_variants;
    double fewest_gradients = std::numeric_limits<double>::infinity();
    for (const Candidate& candidate : candidates) {
        if (candidate.precision != kernel.precision) continue;
        auto variant = find_variant(plan, candidate.method, kernel, candidate.step);
        if (!variant) continue;
        variant->solver_tolerance = candidate.solver_tolerance;
        timed_variants.push_back({*variant, candidate.gradients});
        fewest_gradients = std::min(fewest_gradients, candidate.gradients);
    }
    std::erase_if(timed_variants, [&](const TimedVariant& timed) {
        return timed.gradients > max_relative_gradients * fewest_gradients;
    });
    double shortest = std::numeric_limits<double>::infinity();
    for (unsigned round = 0; round < timed_rounds; ++round) {
        for (TimedVariant& timed : timed_variants) {
            if (stop && stop->load(std::memory_order_relaxed)) return {};
            timed.min_seconds = std::min(timed.min_seconds, seconds_of(plan, timed.variant));
            shortest = std::min(shortest, timed.min_seconds);
        }
        if (round == 0) continue;
        std::erase_if(timed_variants,
                      [&](const TimedVariant& timed) { return timed.min_seconds > max_relative_time * shortest; });
    }
    const auto is_faster = [](const TimedVariant& a, const TimedVariant& b) { return a.min_seconds < b.min_seconds; };
    const auto best = std::min_element(timed_variants.begin(), timed_variants.end(), is_faster);
    if (best == timed_variants.end()) return {};
    return best->variant;
}

}  // namespace kagero
