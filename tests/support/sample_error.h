/// Error of a sample of a plan's rays.
#pragma once

#include "accuracy/reference.h"

namespace kagero::test {

/// Returns the 99th percentile of the pixel errors of a grid × grid sample of rays. The reference is the result of two
/// different methods in double precision, for rays on which they agree.
inline double error_of(Plan& plan, std::uint32_t grid) {
    const SampleRays sample = sample_rays(plan, grid, grid);
    ReferenceSummary summary;
    const ReferenceRays reference = trace_reference(plan, sample, summary);
    std::vector<RayEnd> ends;
    trace(plan, sample.starts, ends);
    return compare_rays(plan, reference, ends).pixels.p99;
}

}  // namespace kagero::test
