/// The decisions of a run: the features that it uses, and those that it leaves out, each with the reason. `kagero
/// explain` prints them.
#pragma once

#include "plan/run_config.h"

#include <string>
#include <vector>

namespace kagero {

/// A feature of the program, and whether a run uses it.
struct Decision {
    std::string feature;
    bool used;
    std::string reason;  ///< Why the feature is left out; empty if it is used.
};

/// The decisions of a run, in the order in which `explain` prints them.
struct Decisions {
    std::vector<Decision> tuning;   ///< About the choice of method, step and precision by trial rays.
    std::vector<Decision> motion;   ///< About the integration of the rays.
    std::vector<Decision> media;    ///< About the integration in each medium.
    std::vector<Decision> ends;     ///< About the events that end rays, and about queries.
    std::vector<Decision> picture;  ///< About camera rays, pixels and layers.
};

/// Returns the decisions about the integration. `method_from_trial` is true if trial rays chose the method.
std::vector<Decision> motion_decisions(const Scene& scene, const RunConfig& run, bool method_from_trial);

/// Returns the decision about the integration of rays in a medium.
Decision medium_decision(const std::string& name, const Scene& scene, const RunConfig& run);

/// Returns all decisions that follow from scene, view and configuration. Decisions::tuning stays empty, because no
/// trial rays are traced.
Decisions decisions_of(const Scene& scene, const View& view, const RunConfig& run);

/// Returns a number as text with at most six significant digits.
std::string plain_number(double x);

}  // namespace kagero
