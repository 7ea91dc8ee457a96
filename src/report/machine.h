/// What a measurement was taken on.
#pragma once

#include <string>

namespace kagero {

/// The processor's own name, or "unknown processor".
std::string processor_name();

}  // namespace kagero
