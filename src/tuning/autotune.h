/// A method and a step for the error that a scene allows, `integrator.max_pixel_error`.
#pragma once

#include "render/render.h"

namespace kagero {

/// Follows a sparse grid of the film's rays by a handful of methods, in double and (where the options leave it open) float, and makes
/// the plan follow the one that keeps 99 % of them within the bound with the fewest floating-point operations, two in float for one in
/// double. A method that the scene states is kept; strategy and lanes are those asked for. Where none does, the plan stays as it was.
/// Plan::pilot tells which it was. The choice does not depend on how fast the machine is, unless the time is limited: then it is among
/// what was tried within so many seconds.
void fit_to_error(Plan& plan, const Progress& progress = {}, double time_limit = std::numeric_limits<double>::infinity());

/// What a picture's plan leaves open is settled by some of its rays: method, step and precision where the scene bounds the error,
/// else precision alone (see choose_precision).
void settle(Plan& plan, const Progress& progress = {}, double time_limit = std::numeric_limits<double>::infinity());

}  // namespace kagero
