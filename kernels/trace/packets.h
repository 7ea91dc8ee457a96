/// The packet types for which a module is compiled. A packet has two registers per variable. With one register, a step
/// is limited by the latency of its operations. With four registers, variables spill on machines with 16 registers, and
/// compilation takes twice as long. `kagero compare` measures both alternatives.
#pragma once

#include "kernels/simd/lanes.h"

namespace kagero {

/// Packets of doubles and of floats.
using PacketDouble = Lanes<double, 2>;
using PacketFloat = Lanes<float, 2>;

}  // namespace kagero
