/// Keys of a scene set from outside.
#pragma once

#include "scene/value.h"

namespace kagero {

/// Merges "key.path=value" into a document. The path is not judged here: a misspelt key is found when the scene is
/// read. `said` is how the user said it, which messages repeat.
void apply_override(Value& root, const std::string& override_text, const std::string& said);

}  // namespace kagero
