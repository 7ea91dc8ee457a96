/// A study of error as a page: charts first, then tables, each with a sentence on how to read it.
#pragma once

#include "study/error_study.h"

#include <string>

namespace kagero {

/// One self-contained page with charts.
std::string error_page(const Plan& plan, const ErrorStudy& study);

}  // namespace kagero
