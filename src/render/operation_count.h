/// Floating-point operations of a run, counted in the programs that it ran.
#pragma once

#include "plan/plan.h"
#include "render/run_report.h"

#include <optional>

namespace kagero {

/// What a gradient and a step of the plan's method cost in its scene.
Operations operations_of(const Plan& plan);

/// Of the tracing loop's derivatives, sums and surveys: lower bounds, see kernels/integrators/costs.h.
double operations_of(const Plan& plan, const Counters& work);

/// Those done in packed form over all of tracing's (Satoh, section 4.2: more than 99.6 %); 0 for one ray at a time,
/// nothing for straight rays and for one ray per vector, whose operations are not counted.
std::optional<double> vectorization_ratio(const Plan& plan, const RunReport& report);

}  // namespace kagero
