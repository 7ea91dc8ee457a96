#include "study/equal_error.h"

#include "accuracy/error_curves.h"
#include "error.h"
#include "render/run.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace kagero {
namespace {

/// Methods that need this many times the gradients of the thriftiest are not timed.
constexpr double wasteful = 3;
/// Candidates are timed in turn, this often, so that a busy moment of the machine is no one's alone; and no more if
/// they take that much longer than the quickest.
constexpr unsigned timed_rounds = 9;
constexpr double slow = 1.5;

struct TimedVariant {
    Variant variant;
    double gradients;
    double least = std::numeric_limits<double>::infinity();  ///< seconds
};

/// Some of the picture's tiles, from all parts of it: a ray's neighbours count, in its packet and for what the packet
/// asks of the scene.
WorkList sample_of(const Plan& plan) {
    constexpr std::size_t rays = 32768;
    const WorkList all = cut(plan, plan.view.window, Schedule::tiles);
    const double whole = std::accumulate(all.costs.begin(), all.costs.end(), 0.0);
    const std::size_t every =
        static_cast<std::size_t>(whole / rays) | 1;  // odd, so that it is no column of the picture
    WorkList sample;
    for (std::size_t i = 0; i < all.tiles.size(); i += every)
        sample.tiles.push_back(all.tiles[i]), sample.costs.push_back(all.costs[i]);
    return sample;
}

double seconds_of(const Plan& own, const Variant& variant) {
    const Plan plan = plan_by(own, variant);
    const Job job = plan.job();
    TileRays rays;
    if (!job.camera) rays = [&](const Tile& tile, RayList& list) { list_rays(plan, tile, list); };
    return run_tiles(plan, job, sample_of(plan), rays, [](const Tile&, const RayEnd*, const RayList&, const Halt&) {})
        .seconds;
}

}  // namespace

Candidates find_candidates(const Plan& plan, double pixels, const std::atomic<bool>* stop) {
    CurveOptions options;
    options.pixel_bound = pixels;
    const ErrorCurves study = measure_curves(plan, options, {}, stop);
    if (!is_known(study.reference)) throw RunError("--equal-error: " + what_is_unknown(study.reference));
    Candidates found;
    for (const StudyCurve& curve : study.curves) {
        const StudyPoint* best = nullptr;
        for (const StudyPoint& point : curve.points)
            if (is_within(point, pixels, &RayErrors::pixels, study.reference) &&
                (!best || point.gradients < best->gradients))
                best = &point;
        if (!best) continue;
        found.push_back(
            {curve.method, curve.precision, best->step, curve.loose ? best->solver_tolerance : -1, best->gradients});
    }
    return found;
}

std::optional<Variant> cheapest_for(const Plan& plan, const KernelInfo& kernel, const Candidates& candidates,
                                    const std::atomic<bool>* stop) {
    std::vector<TimedVariant> served;
    double thriftiest = std::numeric_limits<double>::infinity();
    for (const Candidate& candidate : candidates) {
        if (candidate.precision != kernel.precision) continue;
        auto variant = find_variant(plan, candidate.method, kernel, candidate.step);
        if (!variant) continue;
        variant->solver_tolerance = candidate.solver_tolerance;
        served.push_back({*variant, candidate.gradients});
        thriftiest = std::min(thriftiest, candidate.gradients);
    }
    std::erase_if(served, [&](const TimedVariant& timed) { return timed.gradients > wasteful * thriftiest; });
    double least = std::numeric_limits<double>::infinity();
    for (unsigned round = 0; round < timed_rounds; ++round) {
        for (TimedVariant& timed : served) {
            if (stop && stop->load(std::memory_order_relaxed)) return {};
            timed.least = std::min(timed.least, seconds_of(plan, timed.variant));
            least = std::min(least, timed.least);
        }
        if (round > 0) std::erase_if(served, [&](const TimedVariant& timed) { return timed.least > slow * least; });
    }
    const auto best = std::min_element(served.begin(), served.end(),
                                       [](const TimedVariant& a, const TimedVariant& b) { return a.least < b.least; });
    if (best == served.end()) return {};
    return best->variant;
}

}  // namespace kagero
