#include "render/reference.h"

namespace kagero {
namespace {

struct Candidate {
    const char* method;
    double step;  ///< tolerance of adaptive methods, else a share of the scene's step
};
// The best first. The two lists have no kind of step in common: collocation here, explicit Runge-Kutta or compositions there.
constexpr Candidate references[] = {{"gauss16", 0.5}, {"gauss12", 0.25}, {"gauss8", 0.1}};
constexpr Candidate confirmations[] = {{"rkf78", 1e-14}, {"kahan-li8", 0.05}, {"srkn14", 0.05}, {"dp54", 1e-14}};

template <std::size_t N>
Variant choose(const Plan& plan, const Candidate (&candidates)[N]) {
    for (const Candidate& candidate : candidates) {
        auto found = find_variant(plan, candidate.method, Strategy::packet, Precision::float64, candidate.step);
        if (!found) continue;
        if (!info_of(plan, *found).adaptive) found->step *= plan.job.step;
        return *found;
    }
    throw RunError("this space has no method that could serve as a reference");
}

std::vector<RayEnd> ends_by(Plan& plan, const Variant& variant, const std::vector<RayStart>& starts) {
    const PlanAs as(plan, variant);
    std::vector<RayEnd> ends;
    trace(plan, starts, ends);
    return ends;
}

bool ended(const RayEnd& end) {
    return end.status != Status::step_limit && end.status != Status::failed;
}

}  // namespace

Variant reference_variant(const Plan& plan) {
    return choose(plan, references);
}

ReferenceRays trace_reference(Plan& plan, const SampleRays& sample, ReferenceStory& story) {
    const Variant best = reference_variant(plan), other = choose(plan, confirmations);
    story.method = info_of(plan, best).name, story.confirmed_by = info_of(plan, other).name;
    if (plan.straight) story.method = story.confirmed_by = "straight lines in closed form";
    story.step = best.step, story.confirmed_step = other.step;
    story.adaptive = info_of(plan, best).adaptive, story.confirmed_adaptive = info_of(plan, other).adaptive;

    ReferenceRays reference;
    reference.ends = ends_by(plan, best, sample.starts);
    const std::vector<RayEnd> confirming = ends_by(plan, other, sample.starts);
    reference.conditioning =
        conditioning_of(plan, sample, reference.ends, ends_by(plan, best, sample.right), ends_by(plan, best, sample.below));
    for (std::size_t i = 0; i < reference.ends.size(); ++i) {
        const RayEnd& end = reference.ends[i];
        const bool decided = ended(end) && same_class(plan, end, confirming[i]);
        reference.decided.push_back(decided);
        ++(decided ? story.decided : story.undecided);
        ++story.status[static_cast<int>(end.status)];
    }
    const RayErrors difference = compare_rays(plan, sample, reference, confirming);
    story.uncertainty = difference.position, story.direction = difference.direction, story.pixels = difference.pixels;
    return reference;
}

}  // namespace kagero
