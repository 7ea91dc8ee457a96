/// How wrong the ends of a picture's rays may be, from tracing them again.
#pragma once

#include "render/run.h"

namespace kagero {

/// Of one ray, in pixels of the film. Zero for rays that are captured each time; not a number where a ray ends in different ways,
/// on different objects or not at all, so that there is nothing to measure.
struct EndError {
    double position = 0;  ///< of method, step and precision
    double rounding = 0;  ///< the most that precision alone can have done
};

/// Estimates what a film's layers `position_error` and `rounding_error` want.
///
/// Position: the same rays in double by half the step, or a hundredth of the tolerance; with a method of order p the difference
/// of the ends, times 2^p/(2^p − 1), is the error of the longer steps (Richardson, Phil. Trans. R. Soc. A 210, 1911). Where the
/// space itself bounds steps, halving them changes nothing where it matters; there an adaptive method of order 8 at a tight
/// tolerance takes their place.
///
/// Rounding: a bound, see rounding_bounds.h.
class EndErrors {
public:
    EndErrors(const Plan& plan, bool position, bool rounding);
    /// Of the rays of a tile, in the order of their ends; empty where nothing is wanted, of no meaning where it was told to give up.
    std::vector<EndError> of(const Tile& tile, const RayEnd* ends, const RayList& list, const Halt& halt) const;

private:
    struct Way {
        const KernelInfo* kernel;
        Job job;
    };
    double least_error(const RayEnd& end) const;

    const Plan& plan_;
    bool position_, rounding_;
    std::optional<Way> finer_;  ///< where positions are wanted
    double error_over_difference_ = 1;
};

}  // namespace kagero
