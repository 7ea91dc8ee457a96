/// The methods and steps of a study of error.
#pragma once

#include "plan/variant.h"

#include <string>

namespace kagero {

/// One method over its steps.
struct Ladder {
    Variant variant;            ///< without a step
    std::vector<double> steps;  ///< of adaptive methods: tolerances; the coarsest first
    std::size_t least = 5;      ///< steps to take even where rounding already rules
    bool own = false;           ///< the scene's own method
    bool loose = false;         ///< implicit equations are solved no further than the step's own error deserves
};

struct LadderChoice {
    bool quick = false, full = false;
    std::optional<Strategy> strategy;
    std::optional<Precision> precision;
    bool seeks_cheapest = false;  ///< within a bound: float is tried by the handful too
};

/// Packets in double precision first, implicit methods loosely solved behind them, then float where that suffices, then
/// one ray at a time. Methods that the space cannot serve go into `refused`.
std::vector<Ladder> choose_ladders(const Plan& plan, const LadderChoice& choice, std::vector<std::string>& refused);

/// What a finished ladder shows: errors in scene units, the coarsest step first; not a number where no ray could be
/// compared.
struct Slope {
    std::optional<double> order;  ///< none where fewer than two errors lie between the floor and the size of the scene
    std::optional<double> floor;
};
Slope slope_of(const std::vector<double>& steps, const std::vector<double>& errors, double stated_order,
               double scene_size);

}  // namespace kagero
