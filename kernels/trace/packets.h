/// The value types a module is compiled for. A packet variable takes two registers: one leaves a step waiting for its
/// own results, and four are spilled where there are 16 and compile for twice as long. `kagero compare` shows these two
/// beside it.
#pragma once

#include "kernels/simd/lanes.h"

namespace kagero {

using PacketDouble = Lanes<double, 2>;
using PacketFloat = Lanes<float, 2>;

}  // namespace kagero
