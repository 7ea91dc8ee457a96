/// Rays around a black hole, integrated by Boost.Odeint for comparison with kagero.
#pragma once

#include "kernels/abi.h"

#include <string>
#include <vector>

namespace kagero::bench {

/// The Schwarzschild space (Satoh 2003, equation 16) and its escape sphere, in scene units.
struct Hole {
    double rg;  ///< Schwarzschild radius.
    double escape_radius;
};

/// A stepper of Odeint with one tolerance or one step length.
struct OdeintMethod {
    std::string name;  ///< "stepper/H/number" or "stepper/K/number"; K = r·H is the rescaled Hamiltonian.
    /// Integrates rays that start within the escape sphere, and writes status, q, p and v of their ends. The status is
    /// `escaped` at the escape sphere, or `step_limit` if an inaccurate method does not reach it.
    void (*integrate)(const Hole& hole, double number, const std::vector<RayStart>& starts, std::vector<RayEnd>& ends);
    double number;  ///< Tolerance or step length.
};

/// Returns all combinations of the applicable steppers with tolerances or step lengths, from coarse to fine.
std::vector<OdeintMethod> odeint_methods();

}  // namespace kagero::bench
