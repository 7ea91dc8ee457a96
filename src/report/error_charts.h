/// Charts of a study of error.
#pragma once

#include "render/error_study.h"

#include <string>

namespace kagero {

/// What work is counted in.
enum class Work { nanoseconds, gradients };

/// One line per method and precision, packets only.
std::string work_precision_chart(const Plan& plan, const ErrorStudy& study, Work work);

/// |H − H0| along one ray.
std::string energy_chart(const Plan& plan, const ErrorStudy& study);

/// The scene's own method one ray at a time and in packets.
std::string strategy_chart(const Plan& plan, const ErrorStudy& study);

}  // namespace kagero
