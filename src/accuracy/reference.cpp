#include "accuracy/reference.h"

#include "error.h"
#include "render/trace.h"

#include <cmath>

namespace kagero {
namespace {

/// A method with its step.
struct MethodAndStep {
    const char* method;
    double step;  ///< Tolerance of an adaptive method; otherwise the step divided by that of the scene.
};
/// Two methods: `best` computes the reference, and `other` confirms it.
struct Pair {
    MethodAndStep best, other;
    bool is_fallback = false;  ///< True if the pair is used only if no other pair could be compared.
};
// The first pairs consist of methods of different kinds: collocation with a fixed step, and an explicit adaptive
// method. At the edge of a medium no fixed step is accurate enough, so two adaptive methods of different orders are
// compared. If the gradient of H jumps, only collocation methods are supported. Two of them, with different orders and
// steps, are the fallback.
constexpr Pair pairs[] = {
    {{"gauss16", 0.5}, {"dp85", 1e-12}},
    {{"gauss16", 0.125}, {"dp85", 1e-12}},
    {{"dp85", 1e-12}, {"dp54", 1e-14}},
    {{"gauss16", 0.25}, {"gauss12", 0.125}, true},
};
/// Uncertainty at which the search for a better pair stops: 99th percentile, relative to the scene size.
constexpr double sufficient_agreement = 1e-12;

/// Returns the variant with this method and step, or nothing if the space does not support the method.
std::optional<Variant> variant_of(const Plan& plan, const MethodAndStep& choice) {
    auto found = find_variant(plan, choice.method, Strategy::packet, Precision::float64, choice.step);
    if (found && !info_of(plan, *found).adaptive) found->step *= equivalent_step(plan, *found);
    return found;
}

/// Conditions under which tracing stops early.
struct Limits {
    const Deadline& deadline;
    const std::atomic<bool>* stop;
};

std::vector<RayEnd> ends_by(const Plan& plan, const Variant& variant, const std::vector<RayStart>& starts,
                            const Limits& limits) {
    std::vector<RayEnd> ends;
    const RunReport report = trace(plan_with_variant(plan, variant), starts, ends,
                                   {.stop = limits.stop, .time_limit = limits.deadline.remaining_seconds()});
    if (report.out_of_time)
        throw RunError("the time limit passed before two methods had traced the reference rays; increase --time-limit");
    if (report.interrupted) throw Interrupted();
    return ends;
}

/// Returns true if the status is `hit`, `escaped` or `captured`.
bool has_ended(const RayEnd& end) { return end.status != Status::step_limit && end.status != Status::failed; }

/// Reference rays of one pair of methods.
struct Attempt {
    ReferenceRays rays;
    ReferenceSummary summary;
};

/// Traces the sample with two variants and compares the ray ends.
Attempt compare_pair(const Plan& plan, const SampleRays& sample, const Variant& best, const Variant& other,
                     const Limits& limits) {
    Attempt attempt;
    ReferenceSummary& summary = attempt.summary;
    summary.variant = best;
    summary.method = info_of(plan, best).name;
    summary.confirmed_by = info_of(plan, other).name;
    if (plan.scene->straight) summary.method = summary.confirmed_by = "straight lines in closed form";
    summary.step = stated_step(plan, best);
    summary.confirmed_step = stated_step(plan, other);
    summary.adaptive = info_of(plan, best).adaptive;
    summary.confirmed_adaptive = info_of(plan, other).adaptive;

    ReferenceRays& rays = attempt.rays;
    rays.ends = ends_by(plan, best, sample.starts, limits);
    const std::vector<RayEnd> confirming = ends_by(plan, other, sample.starts, limits);
    rays.conditioning = conditioning_of(plan, sample, rays.ends, ends_by(plan, best, sample.right, limits),
                                        ends_by(plan, best, sample.below, limits));
    for (std::size_t i = 0; i < rays.ends.size(); ++i) {
        const bool confirmed = has_ended(rays.ends[i]) && same_status_and_object(rays.ends[i], confirming[i]);
        rays.confirmed.push_back(confirmed);
        ++(confirmed ? summary.confirmed : summary.unconfirmed);
        ++summary.status[static_cast<int>(rays.ends[i].status)];
    }
    const RayErrors difference = compare_rays(plan, rays, confirming);
    summary.uncertainty = difference.position;
    summary.direction = difference.direction;
    summary.pixels = difference.pixels;
    return attempt;
}

}  // namespace

ReferenceRays trace_reference(const Plan& plan, const SampleRays& sample, ReferenceSummary& summary,
                              const Deadline& deadline, const std::atomic<bool>* stop) {
    const double size = scene_size(*plan.scene);
    // Returns the uncertainty relative to the scene size, or an angle in radians if all rays are ill-conditioned. NaN
    // if no ray has the same status and object by both methods.
    const auto uncertainty = [&](const ReferenceSummary& s) {
        return std::isfinite(s.uncertainty.p99) ? s.uncertainty.p99 / size : s.pixels.p99 * sample.pixel_angle;
    };
    std::optional<Attempt> closest;
    for (const Pair& pair : pairs) {
        const auto best = variant_of(plan, pair.best), other = variant_of(plan, pair.other);
        const bool compared = closest && std::isfinite(uncertainty(closest->summary));
        if (!best || !other || (compared && pair.is_fallback)) continue;
        Attempt attempt = compare_pair(plan, sample, *best, *other, {deadline, stop});
        if (!compared || uncertainty(attempt.summary) < uncertainty(closest->summary)) closest = std::move(attempt);
        if (uncertainty(closest->summary) <= sufficient_agreement) break;
    }
    if (!closest)
        throw RunError(
            "no reference can be computed: this space supports no pair of methods that could confirm each other");
    summary = closest->summary;
    return std::move(closest->rays);
}

}  // namespace kagero
