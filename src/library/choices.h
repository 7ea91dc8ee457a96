/// Conversion between the types of the public headers and those of the program.
#pragma once

#include "plan/plan.h"
#include "scene/load/load.h"

#include <kagero/options.h>

namespace kagero {

/// Returns the options of the program for options of the library. Throws InputError if a name is unknown.
Options options_of(const RunOptions& requested);

/// Loads the description of a scene. Throws InputError if the file or an override is invalid.
SceneDescription description_of(const SceneSource& source, const Options& options, SceneUse use = SceneUse::picture);

/// Returns the choices that a plan contains.
RunChoices run_choices_of(const Plan& plan);

}  // namespace kagero
