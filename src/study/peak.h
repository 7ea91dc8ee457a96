/// Peak arithmetic rate of the processor, the horizontal line of a roofline diagram.
#pragma once

#include "kernels/abi.h"

namespace kagero {

/// Measures the rate of floating-point operations that several threads reach together with independent multiply-adds.
class Peak {
public:
    Peak(const Module& module, Precision precision);

    /// Runs multiply-adds on `threads` threads for 20 to 40 ms and returns the sum of the rates of the threads.
    double operations_per_second(unsigned threads) const;

private:
    const Module& module_;
    Precision precision_;
    std::uint64_t iterations_;  ///< Iterations of the loop of multiply-adds that take one thread 20 to 40 ms.
};

}  // namespace kagero
