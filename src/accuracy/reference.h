/// Where rays really end: by one method at the edge of double precision, confirmed by another that shares no step with
/// it.
#pragma once

#include "render/deadline.h"
#include "accuracy/ray_errors.h"
#include "plan/variant.h"

namespace kagero {

/// How the reference was made, and what is left of doubt.
struct ReferenceStory {
    Variant variant;  ///< of `method`
    std::string method, confirmed_by;
    double step = 0;  ///< of `method`; its tolerance if that is adaptive
    double confirmed_step = 0;
    bool adaptive = false, confirmed_adaptive = false;
    Spread uncertainty;  ///< distance of the two methods' end points over well-conditioned rays, scene units
    Spread direction;    ///< angle between their ends' directions
    Spread pixels;
    std::uint64_t decided = 0, undecided = 0;
    std::uint64_t status[status_count] = {};
};

/// Tries pairs of methods until two agree, and takes the closest. Throws RunError where the space has no two methods to
/// compare, or there was no time to; Interrupted where `stop` was set.
ReferenceRays trace_reference(const Plan& plan, const SampleRays& sample, ReferenceStory& story,
                              const Deadline& deadline = Deadline(), const std::atomic<bool>* stop = nullptr);

}  // namespace kagero
