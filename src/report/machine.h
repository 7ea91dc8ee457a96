/// Properties of the machine and the process for reports.
#pragma once

#include <cstdint>
#include <string>

namespace kagero {

/// Returns the "model name" of /proc/cpuinfo, or "unknown processor".
std::string processor_name();

/// Returns the peak resident memory of this process in bytes.
std::uint64_t peak_memory();

}  // namespace kagero
