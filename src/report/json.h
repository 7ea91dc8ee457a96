/// JSON as the reports write it: keys in the order in which they were added.
#pragma once

#include "render/render.h"

#include <nlohmann/json.hpp>

namespace kagero {

using Json = nlohmann::ordered_json;

/// The whole text, ready for a file. Strings that are not UTF-8 are mended.
std::string text_of(const Json& json);

/// Per thread, the shares of the time in which tiles were worked on: busy, and idle at the end because none were left.
Json threads_json(const RunReport& report);

}  // namespace kagero
