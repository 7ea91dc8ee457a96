/// Overrides: keys of a scene that are set outside the scene file.
#pragma once

#include "scene/value.h"

namespace kagero {

/// Merges "key.path=value" into a document. The path is not checked here; a misspelt key is detected when the scene is
/// read. `option` is the command-line option as the user has written it, for messages. Throws InputError if the text
/// does not have the form "key.path=value", if the object does not exist, or if a key before the last is not a table.
void apply_override(Value& root, const std::string& override_text, const std::string& option);

}  // namespace kagero
