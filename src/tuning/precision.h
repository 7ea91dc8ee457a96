/// Choice between float and double, if the options leave the precision open.
#pragma once

#include "plan/plan.h"

#include <atomic>

namespace kagero {

/// Smallest tolerance for float. With a smaller tolerance, step control would respond to rounding errors.
inline constexpr double min_float_tolerance = 5e-7;

/// Returns the plan with a float kernel if rounding to float is invisible in the picture; otherwise, the plan keeps its
/// kernel. Float is faster, because a register has twice as many lanes. A sparse grid of the film's rays is traced
/// in both precisions with the plan's method and step. Plan::precision_trial and the decisions record the result.
/// Throws Interrupted if `stop` is set during the trial.
Plan choose_precision(Plan plan, const std::atomic<bool>* stop = nullptr);

}  // namespace kagero
