/// The plan of a run as text and JSON.
#pragma once

#include "render/explain.h"

namespace kagero {

std::string explanation_text(const Plan& plan, const Explanation& explanation);
std::string explanation_json(const Plan& plan, const Explanation& explanation);

}  // namespace kagero
