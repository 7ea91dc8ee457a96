/// Options of a comparison of the vectorization strategies.
#pragma once

#include "plan/options.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace kagero {

/// Options of a comparison.
struct CompareOptions {
    std::vector<std::string> isas;       ///< Instruction sets to compare.
    std::vector<std::string> methods;    ///< Methods to compare. Empty: the method of the scene.
    std::vector<std::uint32_t> lanes;    ///< Numbers of lanes. Empty: all, except gangs of at most 64 lanes.
    std::string baseline;                ///< Instruction set of the baseline. Empty: that of each kernel.
    std::optional<Strategy> strategy;    ///< Strategy to compare. Empty: all strategies.
    std::optional<Precision> precision;  ///< Precision to compare. Empty: both precisions.
    /// Bound on the pixel error, in pixels. Each kernel uses its cheapest method that meets the bound. 0: all kernels
    /// use the same method and step.
    double equal_error = 0;
    /// The picture is reduced so that the comparison takes about this time in seconds; 0: it keeps its size. Without
    /// effect with `equal_error`, whose search for methods takes longer.
    double max_seconds = 0;
    unsigned rounds = 5;   ///< Number of timed runs of each kernel.
    unsigned threads = 1;  ///< Number of threads of each run.
};

}  // namespace kagero
