/// Parses TOML text into values. Only toml.cpp includes toml++.
#pragma once

#include "scene/value.h"

namespace kagero {

/// Parses a whole document. `file` is the file name in the positions of the values. Throws InputError if the text is
/// not valid TOML.
Value parse_toml(const std::string& text, const std::string& file);

/// Parses the text after '=' in an override. All values get the position `location`. Text that is not valid TOML and
/// contains no quotes, brackets, commas, '=' or '#' is read as a string. Throws InputError if the text is not one valid
/// value.
Value parse_toml_value(const std::string& text, const FileLocation& location);

}  // namespace kagero
