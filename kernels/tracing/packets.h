/// The value types a module is compiled for: how many registers one packet variable takes. `kagero compare` shows others beside them.
#pragma once

#include "kernels/numeric/lanes.h"

namespace kagero {

#if defined(__AVX512F__)
using PacketDouble = Lanes<double, 2>;
using PacketFloat = Lanes<float, 2>;
#elif defined(__AVX2__)
using PacketDouble = Lanes<double, 2>;
using PacketFloat = Lanes<float, 2>;
#else
using PacketDouble = Lanes<double, 4>;
using PacketFloat = Lanes<float, 2>;
#endif

}  // namespace kagero
