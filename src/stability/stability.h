/// Stiff and extreme cases: small scenes whose outcome theory knows, run through the kernels and the loop that `render`
/// and `trace` use.
#pragma once

#include "kernels/abi.h"

#include <atomic>
#include <functional>
#include <string>
#include <vector>

namespace kagero {

/// What one case came to on one instruction set.
struct StabilityOutcome {
    std::string isa, got;
    bool pass = false;
};

struct StabilityRow {
    std::string name, what, expected;
    std::vector<StabilityOutcome> outcomes;  ///< one per instruction set, in the order of the request
    bool pass() const;                       ///< on all of them
};

/// The ways every case is run: all combinations.
struct StabilityRequest {
    std::vector<std::string> isas{"auto"};
    std::vector<Precision> precisions{Precision::float64, Precision::float32};
    std::vector<Strategy> strategies{Strategy::packet, Strategy::scalar};
    unsigned threads = 0;  ///< 0: all
};

/// Names of all cases, in the order of the table.
std::vector<std::string> stability_case_names();
/// Throws InputError where a name is that of no case.
void require_cases(const std::vector<std::string>& names);

/// Runs the named cases, or all for none, in the order of the table; `done` is called after each, and none begins once
/// `stop` is set. Throws InputError, with a near match, for a name that is none.
std::vector<StabilityRow> run_stability(const std::vector<std::string>& names, const StabilityRequest& request,
                                        const std::function<void(const StabilityRow&)>& done = {},
                                        const std::atomic<bool>* stop = nullptr);

}  // namespace kagero
