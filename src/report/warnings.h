/// Warnings about results that may be wrong. Every verb reports the same conditions in the same words.
#pragma once

#include "plan/plan.h"
#include "render/run_report.h"
#include "report/json.h"

#include <string>
#include <vector>

namespace kagero {

/// A condition that makes results untrustworthy: its key in JSON, and a sentence that states the condition, its size
/// and the remedy for the scene.
struct Warning {
    std::string key;  ///< "max_pixel_error", "failed", "step_limit" or "energy_error".
    std::string text;
};

/// Returns the warnings about the choice of the method by a trial: a bound on the error that may not be met, a stated
/// step that is replaced, and ill-conditioned rays.
std::vector<Warning> warnings_of_trial(const Plan& plan);

/// Returns the warnings about a run: rays that failed or were cut off, and H that is not conserved. The last condition
/// is not tested if the report contains no energy errors, or if trial rays have confirmed the error of the method.
/// `consequence` is added to the warnings about rays, such as "and are black".
std::vector<Warning> warnings_of(const Plan& plan, const RunReport& report, const std::string& consequence = "");

/// Returns the warnings about a picture. If no trial rays have confirmed its error, a few rays test whether H is
/// conserved.
std::vector<Warning> warnings_of_picture(const Plan& plan, RunReport report);

/// Returns the JSON list of warnings: objects with "key" and "text".
Json warnings_json(const std::vector<Warning>& warnings);

}  // namespace kagero
