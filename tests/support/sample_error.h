/// How far a plan's rays end from where they should.
#pragma once

#include "accuracy/reference.h"

namespace kagero::test {

/// The error of 99 % of the rays of a grid, against what two unlike methods in double agree on; pixels.
inline double error_of(Plan& plan, std::uint32_t grid) {
    const SampleRays sample = sample_rays(plan, grid, grid);
    ReferenceStory story;
    const ReferenceRays reference = trace_reference(plan, sample, story);
    std::vector<RayEnd> ends;
    trace(plan, sample.starts, ends);
    return compare_rays(plan, reference, ends).pixels.p99;
}

}  // namespace kagero::test
