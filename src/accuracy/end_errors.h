/// How wrong the ends of a picture's rays may be, from tracing them again.
#pragma once

#include "plan/variant.h"
#include "render/render.h"

namespace kagero {

/// Estimates what a film's layers `position_error` and `rounding_error` show: zero for rays that are captured each
/// time; not a number where a ray ends in different ways, on different objects or not at all, so that there is nothing
/// to measure.
///
/// Position: the same rays in double by half the step, or a hundredth of the tolerance; with a method of order p the
/// difference of the ends, times 2^p/(2^p − 1), is the error of the longer steps (Richardson, Phil. Trans. R. Soc. A
/// 210, 1911). Where the space itself bounds steps, halving them changes nothing where it matters; there an adaptive
/// method of order 8 at a tight tolerance takes their place.
///
/// Rounding: a bound, see rounding_bounds.h.
class EndErrors {
public:
    EndErrors(const Plan& plan, bool position, bool rounding);
    /// Of the rays of a tile, in the order of their ends; empty where nothing is wanted, of no meaning where it was
    /// told to give up.
    std::vector<EndError> of(const Tile& tile, const RayEnd* ends, const RayList& list, const Halt& halt) const;

private:
    double least_error(const RayEnd& end) const;

    const Plan& plan_;
    bool position_, rounding_;
    std::optional<Plan> finer_;  ///< where positions are wanted
    double error_over_difference_ = 1;
};

/// Renders, with the layers `position_error` and `rounding_error` if the film has them.
RunReport render_with_errors(const Plan& plan, Film& film, const Watch& watch = {});

}  // namespace kagero
