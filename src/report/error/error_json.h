/// The JSON report of `error`.
#pragma once

#include "study/error_study.h"

#include <string>

namespace kagero {

/// Returns the JSON of `error`.
std::string error_json(const Plan& plan, const ErrorStudy& study);

}  // namespace kagero
