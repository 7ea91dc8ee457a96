/// Stiff and extreme cases: small scenes whose result is known from theory. Rays are traced by the same kernels as in
/// `render` and `trace`.
#pragma once

#include "kernels/abi.h"

#include <atomic>
#include <functional>
#include <string>
#include <vector>

namespace kagero {

/// Result of one case on one instruction set.
struct StabilityOutcome {
    std::string isa;
    std::string result;  ///< Failures, measured values and notes, or "as expected".
    bool pass = false;
};

/// One case and its results.
struct StabilityRow {
    std::string name, description, expected;
    std::vector<StabilityOutcome> outcomes;  ///< One per instruction set, in the order of the request.
    bool pass() const;                       ///< Returns true if the case passes on all instruction sets.
};

/// Variants of each case. All combinations of instruction set, precision and strategy are run.
struct StabilityRequest {
    std::vector<std::string> isas{"auto"};
    std::vector<Precision> precisions{Precision::float64, Precision::float32};
    std::vector<Strategy> strategies{Strategy::packet, Strategy::scalar};
    unsigned threads = 0;  ///< Number of threads; 0: all processors.
};

/// Returns the names of all cases, in the order of the table in stability.cpp.
std::vector<std::string> stability_case_names();
/// Throws InputError if a name is not the name of a case.
void require_cases(const std::vector<std::string>& names);

/// Runs the named cases, or all cases if `names` is empty, in the order of the table. Calls `done` after each case.
/// Starts no further case if `stop` is set. Throws InputError for an unknown name; the message suggests a similar name.
std::vector<StabilityRow> run_stability(const std::vector<std::string>& names, const StabilityRequest& request,
                                        const std::function<void(const StabilityRow&)>& done = {},
                                        const std::atomic<bool>* stop = nullptr);

}  // namespace kagero
