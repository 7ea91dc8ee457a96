/// What runs for a scene, and what is left out of it.
#pragma once

#include "plan/plan.h"

namespace kagero {

struct LeftOut {
    std::string what, why;
};

struct Explanation {
    std::string kernel;             ///< what the kernel module was compiled with, and for which Hamiltonian and method
    std::vector<std::string> used;
    std::vector<LeftOut> left_out;
};

/// From the plan alone: nothing is traced.
Explanation explain(const Plan& plan);

}  // namespace kagero
