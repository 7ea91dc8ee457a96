/// JSON as the reports write it: keys in the order in which they were added.
#pragma once

#include <nlohmann/json.hpp>

#include <string>

namespace kagero {

using Json = nlohmann::ordered_json;

/// The whole text, ready for a file. Strings that are not UTF-8 are mended.
std::string text_of(const Json& json);

}  // namespace kagero
