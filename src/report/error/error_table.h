/// The tables of an error study, and a gnuplot script for them.
#pragma once

#include "study/error_study.h"

#include <string>

namespace kagero {

/// Returns one line per error bound with the cheapest method that meets it.
std::string error_text(const ErrorStudy& study);

/// Returns CSV with one row per method and step.
std::string error_csv(const ErrorStudy& study);

/// Returns a gnuplot script that plots error against run time from `results.csv` in the same directory.
std::string error_plot(const Plan& plan, const ErrorStudy& study);

}  // namespace kagero
