/// Choice of the method and its step for a picture, by trial rays.
#pragma once

#include "plan/variant.h"
#include "render/run_report.h"

namespace kagero {

/// Bound on the pixel error of a picture whose scene states neither method nor step, tolerance or max_pixel_error.
inline constexpr double default_max_pixel_error = 0.05;

/// Returns true if trial rays choose the method or its step: the scene bounds the pixel error, or states no step and
/// tolerance.
bool needs_method_search(const Plan& plan);

/// Returns the plan's configuration with the given method and step, and the kernel that the options request; nullopt if
/// there is no such kernel.
std::optional<RunConfig> run_config_with(const Plan& plan, Variant variant);

/// Traces a sparse grid of the film's rays in double, with several methods. Chooses the method and step, or tolerance,
/// that keep the error of 99 % of these rays within the bound with the fewest floating-point operations. The bound is
/// `integrator.max_pixel_error`, or `default_max_pixel_error`. A method that the scene states is kept; a formula gets
/// only methods with step control, unless the scene states another one.
///
/// The search does at most a third of the operations of the picture, or as many as take some hundredths of a second.
/// Throws Interrupted if `control.stop` is set.
/// The choice depends only on the scene and the instruction set. If no method is found, the plan gets the method of the
/// search's reference, unless the scene states a method or the reference is too costly. Plan::method_trial and the
/// decisions record the result.
Plan choose_method(Plan plan, const RunControl& control = {});

}  // namespace kagero
