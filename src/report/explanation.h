/// The plan of a run, and that a scene is valid, as text and JSON.
#pragma once

#include "plan/plan.h"

namespace kagero {

/// What takes place, and what is left out and why: the decisions that the plan records.
std::string explanation_text(const Plan& plan);
std::string explanation_json(const Plan& plan);

/// "SCENE: valid (…)".
std::string validity_text(const Plan& plan);
std::string validity_json(const Plan& plan);
/// … of a scene that is refused with this error.
std::string invalidity_json(const std::string& scene, const std::string& error);

}  // namespace kagero
