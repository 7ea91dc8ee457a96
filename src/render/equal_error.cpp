#include "render/equal_error.h"

#include "error.h"
#include "render/error_study.h"

#include <algorithm>
#include <limits>

namespace kagero {
namespace {

/// Methods that need this many times the gradients of the thriftiest are not timed.
constexpr double wasteful = 3;
constexpr unsigned timed_runs = 3;

double seconds_of(Plan& plan, const Variant& variant, const std::vector<RayStart>& starts) {
    const PlanAs as(plan, variant);
    std::vector<RayEnd> ends;
    double least = std::numeric_limits<double>::infinity();
    for (unsigned i = 0; i < timed_runs; ++i) least = std::min(least, trace(plan, starts, ends).seconds);
    return least;
}

}  // namespace

Candidates find_candidates(Plan& plan, double pixels, const std::atomic<bool>* stop) {
    StudyOptions options;
    options.pixel_bound = pixels;
    const ErrorStudy study = study_error(plan, options, {}, stop);
    if (!is_known(study.reference)) throw RunError("--equal-error: " + what_is_unknown(study.reference));
    Candidates found{study.sample.starts, {}};
    for (const StudyCurve& curve : study.curves) {
        const StudyPoint* best = nullptr;
        for (const StudyPoint& point : curve.points)
            if (is_within(point, pixels, &RayErrors::pixels, study.reference) && (!best || point.gradients < best->gradients))
                best = &point;
        if (!best) continue;
        found.all.push_back(
            {curve.method, curve.precision, best->step, curve.loose ? best->solver_tolerance : -1, best->gradients});
    }
    return found;
}

std::optional<Variant> cheapest_for(Plan& plan, const KernelInfo& kernel, const Candidates& candidates,
                                    const std::atomic<bool>* stop) {
    std::vector<std::pair<double, Variant>> served;
    double thriftiest = std::numeric_limits<double>::infinity();
    for (const Candidate& candidate : candidates.all) {
        if (candidate.precision != kernel.precision) continue;
        auto variant = find_variant(plan, candidate.method, kernel, candidate.step);
        if (!variant) continue;
        variant->solver_tolerance = candidate.solver_tolerance;
        served.emplace_back(candidate.gradients, *variant);
        thriftiest = std::min(thriftiest, candidate.gradients);
    }
    std::optional<Variant> best;
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [gradients, variant] : served) {
        if (stop && stop->load(std::memory_order_relaxed)) break;
        if (gradients > wasteful * thriftiest) continue;
        if (const double seconds = seconds_of(plan, variant, candidates.starts); seconds < least) least = seconds, best = variant;
    }
    return best;
}

}  // namespace kagero
