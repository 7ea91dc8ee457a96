/// Reports of the plan of a run (`explain`) and of the validity of a scene (`check`), as text and JSON.
#pragma once

#include "plan/plan.h"
#include "report/warnings.h"

namespace kagero {

/// Returns the text of `explain`: the features that the plan uses, and the features that it leaves out with reasons.
std::string explanation_text(const Plan& plan);
/// Returns the JSON of `explain`.
std::string explanation_json(const Plan& plan);

/// Returns one line, "SCENE: valid (…)", with the space, the method, the number of objects and the film size.
std::string validity_text(const Plan& plan);
/// Returns the JSON of `check` for a valid scene, with the warnings about a trial of its rays.
std::string validity_json(const Plan& plan, const std::vector<Warning>& warnings);
/// Returns the JSON of `check` for a scene that was refused with the message `error`.
std::string invalidity_json(const std::string& scene, const std::string& error);

}  // namespace kagero
