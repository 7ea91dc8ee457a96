/// The decisions about a run, each with its reason: what takes place, and what is left out and why.
#pragma once

#include "plan/run_config.h"

#include <string>
#include <vector>

namespace kagero {

struct Decision {
    std::string what;
    bool taken;
    std::string why_not;  ///< where it is not taken
};

/// In the order in which `explain` prints them.
struct Decisions {
    std::vector<Decision> tuning;  ///< from trial rays: method and precision
    std::vector<Decision> motion;  ///< how rays are integrated
    std::vector<Decision> ends;    ///< where rays end, and how ends are found
    std::vector<Decision> picture; ///< what pixels are made from
};

/// `tuned`: the method was chosen by trial rays.
std::vector<Decision> motion_decisions(const Scene& scene, const RunConfig& run, bool tuned);

/// All decisions that follow from scene, view and configuration.
Decisions decisions_of(const Scene& scene, const View& view, const RunConfig& run);

/// A number in the shortest form that has six digits, as decisions print it.
std::string plain_number(double x);

}  // namespace kagero
