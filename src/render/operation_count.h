/// Floating-point operations of a run, counted in the programs that it executed.
#pragma once

#include "plan/plan.h"
#include "render/run_report.h"

#include <optional>

namespace kagero {

/// Returns the operations per gradient and per step of the plan's method in its scene.
Operations operations_of(const Plan& plan);

/// Returns the operations of the tracing loop for the counted gradients and steps: derivatives, sums and event
/// functions. This is a lower bound, see kernels/integrators/costs.h.
double operations_of(const Plan& plan, const Counters& counters);

/// Returns the share of the operations of tracing that SIMD instructions executed (Satoh 2003, section 4.2: more than
/// 99.6 %). It is 0 for the strategy `scalar`. Returns nullopt for straight rays and for the strategy `per-ray`, whose
/// operations are not counted.
std::optional<double> vectorization_ratio(const Plan& plan, const RunReport& report);

}  // namespace kagero
