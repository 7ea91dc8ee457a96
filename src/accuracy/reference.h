/// Reference ray ends: one method computes them, with an error near the rounding of double, and a second method with
/// other steps confirms them.
#pragma once

#include "accuracy/ray_errors.h"
#include "plan/variant.h"
#include "render/deadline.h"

namespace kagero {

/// Methods of the reference and its remaining uncertainty.
struct ReferenceSummary {
    Variant variant;           ///< Variant of the first method.
    std::string method;        ///< Name of the first method, which computes the reference ends.
    std::string confirmed_by;  ///< Name of the second method.
    /// Step of the first method in the unit of a scene file, or its tolerance if it is adaptive.
    double step = 0;
    double confirmed_step = 0;        ///< Step or tolerance of the second method.
    bool adaptive = false;            ///< True if the first method is adaptive.
    bool confirmed_adaptive = false;  ///< True if the second method is adaptive.
    Percentiles uncertainty;          ///< Distance of both methods' end points, well-conditioned rays, scene units.
    Percentiles direction;            ///< Angle of both methods' end directions, well-conditioned rays, radians.
    Percentiles pixels;               ///< Pixel error of the second method's ends against the first method's ends.
    std::uint64_t confirmed = 0;      ///< Number of rays that end with the same status and object by both methods.
    std::uint64_t unconfirmed = 0;    ///< Number of all other rays.
    std::uint64_t status[status_count] = {};  ///< Number of rays per status, by the first method.
};

/// Traces the sample with several pairs of methods and returns the ray ends of the pair with the least uncertainty.
/// Throws RunError if the space supports no such pair or the deadline passes. Throws Interrupted if `stop` is set.
ReferenceRays trace_reference(const Plan& plan, const SampleRays& sample, ReferenceSummary& summary,
                              const Deadline& deadline = Deadline(), const std::atomic<bool>* stop = nullptr);

}  // namespace kagero
