/// Selection of the methods and steps whose errors are measured.
#pragma once

#include "plan/variant.h"

#include <string>

namespace kagero {

/// The step ladder of one method.
struct Ladder {
    Variant variant;                ///< Method and kernel. Variant::step is not used.
    std::vector<double> steps;      ///< Steps, or tolerances of an adaptive method, the coarsest first.
    std::size_t min_steps = 5;      ///< Number of steps after which rounding or relative work may end the ladder.
    bool is_scene_method = false;   ///< True if this is the method of the scene.
    bool has_loose_solver = false;  ///< See StudyCurve::has_loose_solver.
};

/// Options that select the ladders.
struct LadderChoice {
    /// True: only the scene's method and the representative methods are selected, the latter in double only.
    bool quick = false;
    /// True: every method is selected with the strategy `scalar` too. False: only the scene's method is, unless
    /// `strategy` is set.
    bool full = false;
    std::optional<Strategy> strategy;    ///< Empty: `packet` and `scalar`.
    std::optional<Precision> precision;  ///< Empty: both precisions.
    /// True if the cheapest step within an error bound is searched. Float is then selected for the representative
    /// methods too, and the coarsest step is derived from the space's default step, not from the scene's step.
    bool seeks_cheapest = false;
};

/// Returns the ladders in the order of measurement: the strategy `packet` in double, implicit methods with a loose
/// solver tolerance, `packet` in float, and the strategy `scalar`. Appends the names of methods that do not support the
/// space to `refused`.
std::vector<Ladder> choose_ladders(const Plan& plan, const LadderChoice& choice, std::vector<std::string>& refused);

/// Order and error floor of a measured ladder.
struct LadderFit {
    /// Measured order: slope of log error over log step. Empty if fewer than two errors are suitable for the fit.
    std::optional<double> order;
    std::optional<double> floor;  ///< Smallest error, scene units. Empty if no ray could be compared.
};
/// Returns order and floor of a ladder. `errors` are in scene units, the coarsest step first; an error is NaN if no ray
/// could be compared at that step. `nominal_order` is the order of the method in the literature.
LadderFit fit_ladder(const std::vector<double>& steps, const std::vector<double>& errors, double nominal_order,
                     double scene_size);

}  // namespace kagero
