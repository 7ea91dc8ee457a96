/// The roof of a roofline.
#pragma once

#include "kernels/abi.h"

namespace kagero {

/// Floating-point operations per second that this many threads reach together when nothing but multiply-adds runs: the best of
/// several short runs.
double peak_operations(const Module& module, Precision precision, unsigned threads);

}  // namespace kagero
