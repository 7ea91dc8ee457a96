/// Selection of the methods and steps that a study of error measures.
#pragma once

#include "plan/variant.h"

#include <string>

namespace kagero {

/// The step ladder of one method.
struct Ladder {
    Variant variant;                ///< Method and kernel; the step is not set.
    std::vector<double> steps;      ///< Steps, or tolerances of an adaptive method, the coarsest first.
    std::size_t min_steps = 5;      ///< Number of steps that are measured even if rounding limits the error.
    bool is_scene_method = false;   ///< True if this is the method of the scene.
    bool has_loose_solver = false;  ///< See StudyCurve::has_loose_solver.
};

/// Options that select the ladders.
struct LadderChoice {
    /// Select only the scene's method and the representative methods, the latter in double only.
    bool quick = false;
    /// Select every method with the strategy `scalar` too. Otherwise only the scene's method is selected with `scalar`.
    bool full = false;
    std::optional<Strategy> strategy;    ///< Empty: `packet` and `scalar`.
    std::optional<Precision> precision;  ///< Empty: both precisions.
    /// True if the cheapest step within an error bound is searched. Float is then selected for all methods even if
    /// `quick` is set.
    bool seeks_cheapest = false;
};

/// Returns the ladders in the order of measurement. Packets in double come first, then implicit methods with a loose
/// solver tolerance, then float, then the strategy `scalar`. Methods that do not support the space are appended to
/// `refused`.
std::vector<Ladder> choose_ladders(const Plan& plan, const LadderChoice& choice, std::vector<std::string>& refused);

/// Order and error floor of a measured ladder.
struct Slope {
    /// Measured order. Empty if fewer than two errors lie between the floor and the size of the scene.
    std::optional<double> order;
    std::optional<double> floor;  ///< Smallest error, scene units. Empty if no ray could be compared.
};
/// Fits order and floor to a ladder. `errors` are in scene units, the coarsest step first; an error is NaN if no ray
/// could be compared at that step.
Slope slope_of(const std::vector<double>& steps, const std::vector<double>& errors, double stated_order,
               double scene_size);

}  // namespace kagero
