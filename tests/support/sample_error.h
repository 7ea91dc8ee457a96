/// Measures the pixel errors of a plan.
#pragma once

#include "accuracy/reference.h"

namespace kagero::test {

/// Returns the 99th percentile of the pixel errors of grid × grid camera rays. Two methods in double precision compute
/// the reference. Rays for which these methods disagree are left out.
inline double p99_pixel_error(Plan& plan, std::uint32_t grid) {
    const SampleRays sample = sample_rays(plan, grid, grid);
    ReferenceSummary summary;
    const ReferenceRays reference = trace_reference(plan, sample, summary);
    std::vector<RayEnd> ends;
    trace(plan, sample.starts, ends);
    return compare_rays(plan, reference, ends).pixels.p99;
}

}  // namespace kagero::test
