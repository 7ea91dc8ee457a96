/// A study of error as tables, and the script that draws it.
#pragma once

#include "study/error_study.h"

#include <string>

namespace kagero {

/// The cheapest way for each bound, a line each.
std::string error_text(const ErrorStudy& study);

/// One row per point.
std::string error_csv(const ErrorStudy& study);

/// Draws error against run time from `results.csv` beside it.
std::string error_plot(const Plan& plan, const ErrorStudy& study);

}  // namespace kagero
