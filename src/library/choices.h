/// From the plain values of the public headers to those of the program, and back.
#pragma once

#include "plan/plan.h"

#include <kagero/options.h>

namespace kagero {

/// Throws InputError for a name that is none.
Options options_of(const RunOptions& options);

SceneDescription description_of(const SceneSource& source, const Options& options);

RunChoices choices_of(const Plan& plan);

}  // namespace kagero
