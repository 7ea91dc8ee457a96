/// A study of error as JSON.
#pragma once

#include "study/error_study.h"

#include <string>

namespace kagero {

std::string error_json(const Plan& plan, const ErrorStudy& study);

}  // namespace kagero
