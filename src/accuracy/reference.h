/// Reference ray ends. One method computes them with an error near the rounding error of double; a second method, with
/// other steps, confirms them.
#pragma once

#include "accuracy/ray_errors.h"
#include "plan/variant.h"
#include "render/deadline.h"

namespace kagero {

/// The two methods of a reference and the difference of their ray ends, which is the uncertainty of the reference.
struct ReferenceSummary {
    Variant variant;                   ///< Variant of the first method, which computes the reference ends.
    std::string method;                ///< Name of the first method.
    std::string confirming_method;     ///< Name of the second method.
    double step = 0;                   ///< Step of the first method in the unit of a scene file, or its tolerance.
    double confirming_step = 0;        ///< Step or tolerance of the second method.
    bool adaptive = false;             ///< True if the first method is adaptive, so that `step` is its tolerance.
    bool confirming_adaptive = false;  ///< True if the second method is adaptive.
    Percentiles uncertainty;        ///< Distance between both methods' end points, well-conditioned rays; scene units.
    Percentiles direction;          ///< Angle between both methods' end directions, well-conditioned rays; radians.
    Percentiles pixels;             ///< Pixel error of the second method's ends against the first method's ends.
    std::uint64_t confirmed = 0;    ///< Number of rays for which ReferenceRays::confirmed is true.
    std::uint64_t unconfirmed = 0;  ///< Number of all other rays.
    std::uint64_t status[status_count] = {};  ///< Number of rays per status, by the first method.
};

/// Traces the sample with several pairs of methods. Returns the reference rays of the pair with the least uncertainty,
/// and writes the summary of this pair to `summary`. Throws RunError if the space supports no such pair or the deadline
/// passes. Throws Interrupted if `stop` is set.
ReferenceRays trace_reference(const Plan& plan, const SampleRays& sample, ReferenceSummary& summary,
                              const Deadline& deadline = Deadline(), const std::atomic<bool>* stop = nullptr);

}  // namespace kagero
