/// The cheapest way to a bound on the error, kernel by kernel.
#pragma once

#include "render/variant.h"

namespace kagero {

/// A method at the step that meets a bound with the least work.
struct Candidate {
    std::string method;
    Precision precision{};
    double step = 0;               ///< of adaptive methods: the tolerance
    double solver_tolerance = -1;  ///< negative: the scene's
    double gradients = 0;          ///< per ray
};

/// The rays by which kernels are timed, and what may be asked of them: 99 % end within `pixels` of where they should.
struct Candidates {
    std::vector<RayStart> starts;
    std::vector<Candidate> all;
};
Candidates find_candidates(Plan& plan, double pixels, const std::atomic<bool>* stop);

/// The quickest of the candidates by this kernel; nothing where none is in its precision, or it refuses them all.
std::optional<Variant> cheapest_for(Plan& plan, const KernelInfo& kernel, const Candidates& candidates,
                                    const std::atomic<bool>* stop);

}  // namespace kagero
