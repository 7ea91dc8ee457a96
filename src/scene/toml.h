/// TOML text to values; the only header of toml++ is in toml.cpp.
#pragma once

#include "scene/value.h"

namespace kagero {

/// Reads a whole document. `file` is the name that places carry. Throws InputError for what is not TOML.
Value parse_toml(const std::string& text, const std::string& file);

/// Reads the right-hand side of an override, all of it placed at `place`. A bare word is a string.
Value parse_toml_value(const std::string& text, const Place& place);

}  // namespace kagero
