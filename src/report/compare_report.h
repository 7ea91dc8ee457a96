/// Strategies side by side, for programs and for people.
#pragma once

#include "study/compare.h"

#include <string>

namespace kagero {

std::string compare_json(const SceneDescription& scene, const CompareOptions& options, const Comparison& comparison);
std::string compare_text(const CompareOptions& options, const Comparison& comparison);

}  // namespace kagero
