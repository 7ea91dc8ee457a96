/// The HTML page of an error study: charts, then tables, each with an explanation.
#pragma once

#include "study/error_study.h"

#include <string>

namespace kagero {

/// Returns one self-contained HTML page.
std::string error_page(const Plan& plan, const ErrorStudy& study);

}  // namespace kagero
