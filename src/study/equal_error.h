/// The cheapest way to a bound on the error, kernel by kernel.
#pragma once

#include "plan/variant.h"

#include <atomic>
#include <string>
#include <vector>

namespace kagero {

/// A method at the step that meets a bound with the least work.
struct Candidate {
    std::string method;
    Precision precision{};
    double step = 0;               ///< of adaptive methods: the tolerance
    double solver_tolerance = -1;  ///< negative: the scene's
    double gradients = 0;          ///< per ray
};

/// Of each method the thriftiest step by which 99 % of the rays end within `pixels` of where they should.
using Candidates = std::vector<Candidate>;
Candidates find_candidates(const Plan& plan, double pixels, const std::atomic<bool>* stop);

/// The candidate that is the quickest by this kernel, of a sample of the picture's tiles; nothing where none is in its
/// precision, or it refuses them all.
std::optional<Variant> cheapest_for(const Plan& plan, const KernelInfo& kernel, const Candidates& candidates,
                                    const std::atomic<bool>* stop);

}  // namespace kagero
