#include "accuracy/reference.h"

#include "error.h"
#include "render/trace.h"

#include <cmath>

namespace kagero {
namespace {

struct Candidate {
    const char* method;
    double step;  ///< tolerance of adaptive methods, else a share of the scene's step
};
struct Pair {
    Candidate best, other;
    bool alike = false;  ///< taken only where no unlike pair serves
};
// Unlike methods first: collocation at a fixed step against explicit stages at steps of their own. Where light runs
// against the edge of a medium no fixed step suffices; there two adaptive methods of other orders and stages must do.
// Where the slope of H jumps collocation alone serves: two of it, of other orders, stages and steps.
constexpr Pair pairs[] = {
    {{"gauss16", 0.5}, {"dp85", 1e-12}},
    {{"gauss16", 0.125}, {"dp85", 1e-12}},
    {{"dp85", 1e-12}, {"dp54", 1e-14}},
    {{"gauss16", 0.25}, {"gauss12", 0.125}, true},
};
/// Ends this close (99 % of the rays; in sizes of the scene) need no better pair.
constexpr double close_enough = 1e-12;

std::optional<Variant> find(const Plan& plan, const Candidate& candidate) {
    auto found = find_variant(plan, candidate.method, Strategy::packet, Precision::float64, candidate.step);
    if (found && !info_of(plan, *found).adaptive) found->step *= usual_step(plan, *found);
    return found;
}

/// What ends the search.
struct Limits {
    const Deadline& deadline;
    const std::atomic<bool>* stop;
};

std::vector<RayEnd> ends_by(const Plan& plan, const Variant& variant, const std::vector<RayStart>& starts,
                            const Limits& limits) {
    std::vector<RayEnd> ends;
    const RunReport report =
        trace(plan_by(plan, variant), starts, ends, {.stop = limits.stop, .time_limit = limits.deadline.left()});
    if (report.out_of_time) throw RunError("the time was up before two methods had shown how rays end");
    if (report.interrupted) throw Interrupted();
    return ends;
}

bool ended(const RayEnd& end) {
    return end.status != Status::step_limit && end.status != Status::failed;
}

struct Attempt {
    ReferenceRays rays;
    ReferenceStory story;
};

Attempt attempt(const Plan& plan, const SampleRays& sample, const Variant& best, const Variant& other,
                const Limits& limits) {
    Attempt made;
    ReferenceStory& story = made.story;
    story.variant = best;
    story.method = info_of(plan, best).name, story.confirmed_by = info_of(plan, other).name;
    if (plan.scene->straight) story.method = story.confirmed_by = "straight lines in closed form";
    story.step = stated_step(plan, best), story.confirmed_step = stated_step(plan, other);
    story.adaptive = info_of(plan, best).adaptive, story.confirmed_adaptive = info_of(plan, other).adaptive;

    ReferenceRays& rays = made.rays;
    rays.ends = ends_by(plan, best, sample.starts, limits);
    const std::vector<RayEnd> confirming = ends_by(plan, other, sample.starts, limits);
    rays.conditioning = conditioning_of(plan, sample, rays.ends, ends_by(plan, best, sample.right, limits),
                                        ends_by(plan, best, sample.below, limits));
    for (std::size_t i = 0; i < rays.ends.size(); ++i) {
        const bool decided = ended(rays.ends[i]) && same_class(rays.ends[i], confirming[i]);
        rays.decided.push_back(decided);
        ++(decided ? story.decided : story.undecided);
        ++story.status[static_cast<int>(rays.ends[i].status)];
    }
    const RayErrors difference = compare_rays(plan, rays, confirming);
    story.uncertainty = difference.position, story.direction = difference.direction, story.pixels = difference.pixels;
    return made;
}

}  // namespace

ReferenceRays trace_reference(const Plan& plan, const SampleRays& sample, ReferenceStory& story,
                              const Deadline& deadline, const std::atomic<bool>* stop) {
    const double size = scene_size(*plan.scene);
    // In sizes of the scene, or where all rays are ill-conditioned as an angle; not a number where no two rays ended
    // alike.
    const auto doubt = [&](const ReferenceStory& s) {
        return std::isfinite(s.uncertainty.p99) ? s.uncertainty.p99 / size : s.pixels.p99 * sample.pixel_angle;
    };
    std::optional<Attempt> least;
    for (const Pair& pair : pairs) {
        const auto best = find(plan, pair.best), other = find(plan, pair.other);
        const bool compared = least && std::isfinite(doubt(least->story));
        if (!best || !other || (compared && pair.alike)) continue;
        Attempt made = attempt(plan, sample, *best, *other, {deadline, stop});
        if (!compared || doubt(made.story) < doubt(least->story)) least = std::move(made);
        if (doubt(least->story) <= close_enough) break;
    }
    if (!least) throw RunError("this space has no two methods that could confirm each other as a reference");
    story = least->story;
    return std::move(least->rays);
}

}  // namespace kagero
