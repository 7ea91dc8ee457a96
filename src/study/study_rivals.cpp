#include "study/study.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kagero {
namespace {

/// Pixels.
constexpr std::uint32_t picture_width = 128;

}  // namespace

/// Of the points of a method that are shown, the one whose gradient evaluations per ray are nearest to so many.
const Timed* Study::nearest_in_work(const std::string& method, double gradients) const {
    const Timed* nearest = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const Timed& timed : timed_) {
        const StudyCurve& curve = study_.curves[timed.curve];
        if (curve.method != method || curve.loose || !study_.shows(curve)) continue;
        const double off = std::abs(std::log(std::max(1.0, gradients_of(timed)) / gradients));
        if (off < least) least = off, nearest = &timed;
    }
    return nearest;
}

/// The scene's own method at about the scene's step, and what typical ones of low order do with about as much work.
std::vector<const Timed*> Study::rivals() const {
    const std::string& own = plan_.scene.integrator.method;
    const Timed* mine = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const Timed& timed : timed_) {
        const StudyCurve& curve = study_.curves[timed.curve];
        if (!curve.own || curve.loose || !study_.shows(curve)) continue;
        const double wanted = curve.info->adaptive ? plan_.job.tolerance : plan_.job.step;
        const double off = std::abs(std::log(timed.variant.step / wanted));
        if (off < least) least = off, mine = &timed;
    }
    if (!mine) return {};
    std::vector<const Timed*> all{mine};
    const double work = gradients_of(*mine);
    constexpr std::uint32_t highest_order = 4;
    for (std::uint32_t i = 0; i < plan_.module->integrator_count; ++i) {
        const IntegratorInfo& info = plan_.module->integrators[i];
        if (!info.typical || info.adaptive || info.order > highest_order || info.name == own) continue;
        if (const Timed* rival = nearest_in_work(info.name, work)) all.push_back(rival);
    }
    return all;
}

void Study::follow_energy() {
    if (drift_rays_.empty() || plan_.straight) return;
    for (const Timed* timed : rivals()) {
        if (stopped()) return;
        study_.energy.push_back(energy_trace(plan_, timed->variant, study_.sample.starts[most_bent_]));
        study_.energy.back().gradients = gradients_of(*timed);
    }
}

void Study::compare_pictures() {
    if (plan_.straight || stopped()) return;
    const std::vector<const Timed*> all = rivals();
    std::vector<Variant> variants;
    for (const Timed* timed : all) variants.push_back(timed->variant);
    study_.pictures = picture_errors(plan_, picture_width, study_.reference.variant, variants, stop_);
    for (std::size_t i = 0; i < study_.pictures.size(); ++i) study_.pictures[i].gradients = gradients_of(*all[i]);
    if (!stopped()) study_.map = error_map(plan_, picture_width, study_.reference.variant, stop_);
    tell(1);
}

}  // namespace kagero
