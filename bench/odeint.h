/// Light around a hole by Boost.Odeint: what kagero's rays are measured against.
#pragma once

#include "kernels/abi.h"

#include <string>
#include <vector>

namespace kagero::bench {

struct Hole {
    double rg;
    double escape_radius;
};

/// A stepper with one tolerance, or one step length: follows light from its start, within the escape sphere of a hole,
/// to that sphere, and writes status, q, p and v of its ends: `escaped`, or `step_limit` where a coarse method loses it
/// to the hole.
struct OdeintWay {
    std::string name;  ///< stepper/function that is integrated/number
    void (*follow)(const Hole& hole, double number, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends);
    double number;
};

/// Odeint's steppers that serve such equations, from coarse to fine.
std::vector<OdeintWay> odeint_ways();

}  // namespace kagero::bench
