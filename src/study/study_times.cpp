#include "study/study.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kagero {
namespace {

/// Seconds to spend on the repeated runs of each point, if four times the asked repetitions reach so far.
constexpr double seconds_per_point = 0.15;
/// The same of a quick study.
constexpr double seconds_per_quick_point = 0.25;

}  // namespace

/// The repetitions are interleaved: what disturbs the machine for a while disturbs every method.
void Study::take_times() {
    double total = 0, done = 0;
    unsigned most = 0;
    for (Timed& timed : timed_) {
        // Short runs are disturbed more easily, and cost little to repeat.
        const double wanted = std::min(4.0, std::ceil(seconds_per_point / (timed.estimate * study_.options.repeats)));
        timed.repeats = study_.options.repeats * static_cast<unsigned>(std::max(1.0, wanted));
        if (study_.options.quick)
            timed.repeats = static_cast<unsigned>(std::clamp(seconds_per_quick_point / timed.estimate, 1.0, double(timed.repeats)));
        total += timed.estimate * timed.repeats, done += timed.estimate * double(timed.with.size());
        most = std::max(most, timed.repeats);
    }
    if (study_.options.quick) study_.options.repeats = 1;
    const double rays = double(timed_rays_.size());
    for (unsigned repeat = 0; repeat < most; ++repeat)
        for (Timed& timed : timed_) {
            if (stopped()) return keep_times();
            if (repeat >= timed.repeats || repeat < timed.with.size()) continue;
            PlanAs as(plan_, timed.variant);
            as.on_threads(study_.options.threads);
            std::vector<RayEnd> ends;
            const RunReport with = trace(plan_, timed_rays_, ends, watch());
            as.without_surfaces(timed.most_steps);
            const RunReport without = trace(plan_, timed_rays_, ends, watch());
            if (with.interrupted || without.interrupted) return keep_times();
            timed.with.push_back(1e9 * with.seconds / rays), timed.without.push_back(1e9 * without.seconds / rays);
            done += timed.estimate;
            tell(climbing() + (0.95 - climbing()) * done / total);
        }
    keep_times();
}

void Study::keep_times() {
    for (const Timed& timed : timed_) {
        StudyPoint& point = study_.curves[timed.curve].points[timed.point];
        point.time = timing_of(timed.with), point.time_without = timing_of(timed.without);
    }
}

Cheapest Study::cheapest(double error, const char* measure, Spread RayErrors::*spread) const {
    Cheapest best{error, measure, 0, 0, false};
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < study_.curves.size(); ++c)
        for (std::size_t p = 0; p < study_.curves[c].points.size(); ++p) {
            const StudyPoint& point = study_.curves[c].points[p];
            if (!is_within(point, error, spread, study_.reference) || !(point.time.median < least)) continue;
            least = point.time.median;
            best.curve = c, best.point = p, best.found = true;
        }
    return best;
}

void Study::choose_cheapest() {
    study_.cheapest = {cheapest(0.25, "pixels", &RayErrors::pixels), cheapest(1e-3, "pixels", &RayErrors::pixels),
                       cheapest(1e-6, "direction", &RayErrors::direction)};
}

}  // namespace kagero
