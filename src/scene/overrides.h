/// Overrides: keys of a scene that are set outside the scene file.
#pragma once

#include "scene/value.h"

namespace kagero {

/// Returns the keys of a path such as `object."left wall".color`, which an '=' may end. Keys may be quoted. Throws
/// InputError if a key is empty.
std::vector<std::string> keys_of_path(const std::string& path, const FileLocation& location);

/// Sets the value at a path in a document, as apply_override does. Value::key is ignored. `location` is the position of
/// the path, for messages.
void set_value(Value& root, const std::vector<std::string>& path, Value value, const FileLocation& location);

/// Merges "key.path=value" into a document. The path is not checked here; a misspelt key is detected when the scene is
/// read. `option` is the command-line option as the user has written it, for messages. Throws InputError if the text
/// does not have the form "key.path=value", if the object does not exist, or if a key before the last is not a table.
void apply_override(Value& root, const std::string& override_text, const std::string& option);

}  // namespace kagero
