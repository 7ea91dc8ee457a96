#include "accuracy/reference.h"

#include "error.h"
#include "render/trace.h"

#include <cmath>

namespace kagero {
namespace {

/// A method with its step.
struct MethodAndStep {
    const char* method;
    double step;  ///< Tolerance of an adaptive method; otherwise, the step divided by `equivalent_step`.
};
/// Two methods: `computing` computes the reference ends, and `confirming` confirms them.
struct MethodPair {
    MethodAndStep computing, confirming;
    bool is_fallback = false;  ///< True: the pair is used only if the uncertainty of every earlier pair is NaN.
};
// The first two pairs consist of methods of different kinds: collocation with a fixed step, and an explicit adaptive
// method. At the edge of a medium no fixed step is accurate enough, so the third pair consists of two adaptive methods
// of different orders. If the gradient of H jumps, only collocation methods are supported, so the fallback is a pair of
// collocation methods with different orders and steps.
constexpr MethodPair pairs[] = {
    {{"gauss16", 0.5}, {"dp85", 1e-12}},
    {{"gauss16", 0.125}, {"dp85", 1e-12}},
    {{"dp85", 1e-12}, {"dp54", 1e-14}},
    {{"gauss16", 0.25}, {"gauss12", 0.125}, true},
};
/// Uncertainty at which the search for a better pair stops: 99th percentile, relative to the scene size.
constexpr double sufficient_agreement = 1e-12;

/// Returns the variant with this method and step, or nullopt if the space does not support the method.
std::optional<Variant> variant_of(const Plan& plan, const MethodAndStep& choice) {
    auto found = find_variant(plan, choice.method, Strategy::packet, Precision::float64, choice.step);
    if (found && !info_of(plan, *found).adaptive) found->step *= equivalent_step(plan, *found);
    return found;
}

/// Conditions that interrupt tracing.
struct Limits {
    const Deadline& deadline;
    const std::atomic<bool>* stop;
};

/// Traces the rays and returns their ends. Throws RunError if the deadline passes, and Interrupted if `stop` is set.
std::vector<RayEnd> trace_ends(const Plan& plan, const Variant& variant, const std::vector<RayStart>& starts,
                               const Limits& limits) {
    std::vector<RayEnd> ends;
    const RunReport report = trace(plan_with_variant(plan, variant), starts, ends,
                                   {.stop = limits.stop, .time_limit = limits.deadline.remaining_seconds()});
    if (report.out_of_time)
        throw RunError("the time limit passed before two methods had traced the reference rays; increase --time-limit");
    if (report.interrupted) throw Interrupted();
    return ends;
}

/// Reference rays by one pair of methods, and their uncertainty.
struct Attempt {
    ReferenceRays rays;
    ReferenceSummary summary;
};

/// Traces the sample with two variants and compares the ray ends.
Attempt compare_pair(const Plan& plan, const SampleRays& sample, const Variant& computing, const Variant& confirming,
                     const Limits& limits) {
    Attempt attempt;
    ReferenceSummary& summary = attempt.summary;
    summary.variant = computing;
    summary.method = info_of(plan, computing).name;
    summary.confirming_method = info_of(plan, confirming).name;
    if (plan.scene->straight) summary.method = summary.confirming_method = "straight lines in closed form";
    summary.step = stated_step(plan, computing);
    summary.confirming_step = stated_step(plan, confirming);
    summary.adaptive = info_of(plan, computing).adaptive;
    summary.confirming_adaptive = info_of(plan, confirming).adaptive;

    ReferenceRays& rays = attempt.rays;
    rays.ends = trace_ends(plan, computing, sample.starts, limits);
    const std::vector<RayEnd> confirming_ends = trace_ends(plan, confirming, sample.starts, limits);
    rays.conditioning = conditioning_of(plan, sample, rays.ends, trace_ends(plan, computing, sample.right, limits),
                                        trace_ends(plan, computing, sample.below, limits));
    summary.unconfirmed = confirm(rays, confirming_ends);
    summary.confirmed = rays.ends.size() - summary.unconfirmed;
    for (const RayEnd& end : rays.ends) ++summary.status[static_cast<int>(end.status)];
    const RayErrors difference = compare_rays(plan, rays, confirming_ends);
    summary.uncertainty = difference.position;
    summary.direction = difference.direction;
    summary.pixels = difference.pixels;
    return attempt;
}

}  // namespace

ReferenceRays trace_reference(const Plan& plan, const SampleRays& sample, ReferenceSummary& summary,
                              const Deadline& deadline, const std::atomic<bool>* stop) {
    const double size = scene_size(*plan.scene);
    // Returns the uncertainty relative to the scene size, or an angle in radians if all rays are ill-conditioned.
    // Returns NaN if no ray has a visible end with the same status and object by both methods.
    const auto uncertainty = [&](const ReferenceSummary& s) {
        return std::isfinite(s.uncertainty.p99) ? s.uncertainty.p99 / size : s.pixels.p99 * sample.pixel_angle;
    };
    std::optional<Attempt> closest;  // the attempt with the least uncertainty
    for (const MethodPair& pair : pairs) {
        const auto computing = variant_of(plan, pair.computing), confirming = variant_of(plan, pair.confirming);
        const bool is_known = closest && std::isfinite(uncertainty(closest->summary));
        if (!computing || !confirming || (is_known && pair.is_fallback)) continue;
        Attempt attempt = compare_pair(plan, sample, *computing, *confirming, {deadline, stop});
        if (!is_known || uncertainty(attempt.summary) < uncertainty(closest->summary)) closest = std::move(attempt);
        if (uncertainty(closest->summary) <= sufficient_agreement) break;
    }
    if (!closest)
        throw RunError(
            "no reference can be computed: this space supports no pair of methods that could confirm each other");
    summary = closest->summary;
    return std::move(closest->rays);
}

}  // namespace kagero
