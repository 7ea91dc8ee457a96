/// What `error` writes: JSON, a table, a gnuplot script and a page.
#pragma once

#include "study/error_study.h"

#include <string>

namespace kagero {

std::string error_json(const Plan& plan, const ErrorStudy& study);

/// The cheapest way for each bound, a line each.
std::string error_text(const ErrorStudy& study);

/// One row per point.
std::string error_csv(const ErrorStudy& study);

/// Draws error against run time from `results.csv` beside it.
std::string error_plot(const Plan& plan, const ErrorStudy& study);

/// One self-contained page with charts.
std::string error_page(const Plan& plan, const ErrorStudy& study);

}  // namespace kagero
