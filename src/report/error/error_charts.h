/// The charts of an error study, as SVG.
#pragma once

#include "study/error_study.h"

#include <string>

namespace kagero {

/// The quantity on the x axis of a work-precision chart, per ray.
enum class Work { nanoseconds, gradients };

/// Returns a chart of pixel error against work. Each line is one method in one precision, with the main strategy of the
/// study. The chart contains the method of the scene, the cheapest method for each error bound, and the representative
/// methods.
std::string work_precision_chart(const Plan& plan, const ErrorStudy& study, Work work);

/// Returns a chart of pixel error against run time for all methods of one family. Returns "" if work_precision_chart
/// contains all of them.
std::string family_chart(const Plan& plan, const ErrorStudy& study, MethodFamily family);

/// Returns a chart of the relative error of H along one ray for several methods.
std::string energy_chart(const Plan& plan, const ErrorStudy& study);

/// Returns a bar chart of the run time per ray of the scene's method for every instruction set and strategy.
std::string strategy_chart(const ErrorStudy& study);

}  // namespace kagero
