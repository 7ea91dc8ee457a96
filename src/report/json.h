/// The JSON type of the reports. It keeps keys in the order of insertion and writes NaN and infinity as null.
#pragma once

#include <nlohmann/json.hpp>

#include <string>

namespace kagero {

using Json = nlohmann::ordered_json;

/// Returns indented text with a final newline. Invalid UTF-8 in strings is replaced by U+FFFD.
std::string text_of(const Json& json);

}  // namespace kagero
