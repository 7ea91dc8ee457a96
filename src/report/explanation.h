/// The plan of a run, and that a scene is valid, as text and JSON.
#pragma once

#include "plan/decisions.h"

namespace kagero {

std::string explanation_text(const Plan& plan, const Explanation& explanation);
std::string explanation_json(const Plan& plan, const Explanation& explanation);

/// "SCENE: valid (…)".
std::string validity_text(const Plan& plan);
std::string validity_json(const Plan& plan);
/// … of a scene that is refused with this error.
std::string invalidity_json(const std::string& scene, const std::string& error);

}  // namespace kagero
