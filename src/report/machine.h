/// What a measurement was taken on.
#pragma once

#include <cstdint>
#include <string>

namespace kagero {

/// The processor's own name, or "unknown processor".
std::string processor_name();

/// The most memory this process has held, in bytes.
std::uint64_t peak_memory();

}  // namespace kagero
