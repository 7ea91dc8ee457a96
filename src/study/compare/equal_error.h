/// Search for the cheapest method that meets a bound on the error, separately for each kernel.
#pragma once

#include "plan/variant.h"

#include <atomic>
#include <string>
#include <vector>

namespace kagero {

/// A method, and the step with which the method meets a bound on the error with the fewest gradients.
struct Candidate {
    std::string method;
    Precision precision{};
    double step = 0;               ///< Step in the kernel's unit, or the tolerance of an adaptive method.
    double solver_tolerance = -1;  ///< Relative solver tolerance; negative: that of the scene.
    double gradients = 0;          ///< Gradient evaluations per ray.
};

using Candidates = std::vector<Candidate>;
/// Returns the cheapest step of each method and precision: the one that needs the fewest gradients among those whose
/// 99th percentile of the pixel error is at most `pixels`. Throws RunError if a second method does not confirm the
/// reference, see `is_confirmed`.
Candidates find_candidates(const Plan& plan, double pixels, const std::atomic<bool>* stop);

/// Times the candidates of the kernel's precision on a sample of the picture's tiles and returns the fastest. Returns
/// nothing if the kernel supports none of them, or if `stop` is set.
std::optional<Variant> cheapest_for(const Plan& plan, const KernelInfo& kernel, const Candidates& candidates,
                                    const std::atomic<bool>* stop);

}  // namespace kagero
