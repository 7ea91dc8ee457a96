/// The roof of a roofline.
#pragma once

#include "kernels/abi.h"

namespace kagero {

/// How many floating-point operations per second a number of threads reach together when nothing but multiply-adds
/// runs.
class Peak {
public:
    Peak(const Module& module, Precision precision);

    /// In one run of some 20 ms.
    double operations_per_second(unsigned threads) const;

private:
    const Module& module_;
    Precision precision_;
    std::uint64_t rounds_;
};

}  // namespace kagero
