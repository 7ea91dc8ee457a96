/// Charts of a study of error.
#pragma once

#include "study/error_study.h"

#include <string>

namespace kagero {

/// What work is counted in.
enum class Work { nanoseconds, gradients };

/// One line per method and precision, of the study's strategy: the representatives of each family, the scene's own
/// method and the cheapest ones.
std::string work_precision_chart(const Plan& plan, const ErrorStudy& study, Work work);

/// The same over run time for all methods of one family; empty where the study has none that the chart above leaves
/// out.
std::string family_chart(const Plan& plan, const ErrorStudy& study, Family family);

/// |H − H0| along one ray.
std::string energy_chart(const Plan& plan, const ErrorStudy& study);

/// The scene's own method by every strategy, instruction set by instruction set.
std::string strategy_chart(const ErrorStudy& study);

}  // namespace kagero
