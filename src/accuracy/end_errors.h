/// Estimates of the errors of a picture's ray ends, from a second integration of the same rays.
#pragma once

#include "plan/variant.h"
#include "render/render.h"

namespace kagero {

/// Estimates the errors that the film layers `position_error` and `rounding_error` show, in pixels. An error is zero if
/// the ray is captured in both runs. It is NaN if the two runs end with different statuses or on different objects, or
/// if the ray does not end.
///
/// Position error: the rays are traced again in double with half the step, or with a hundredth of the tolerance. If
/// adaptive methods cannot meet a tolerance as small as that, a hundred times the tolerance is used. For a method of
/// order p, the difference of the ends times 2^p/(2^p − 1) is the error of the longer step (Richardson, Phil. Trans. R.
/// Soc. A 210, 1911). If the space bounds the step, half the step may change nothing, because the bound already forces
/// shorter steps. In that case an adaptive method of order 8 with a tight tolerance is used instead.
///
/// Rounding error: a bound, see rounding_bounds.h.
class EndErrors {
public:
    /// Prepares the runs for the requested layers.
    EndErrors(const Plan& plan, bool position, bool rounding);
    /// Returns the errors of the rays of a tile, in the order of their ends. The result is empty if neither error is
    /// requested. It is meaningless if `cancel` returned true.
    std::vector<EndError> estimate(const Tile& tile, const RayEnd* ends, const RayList& list,
                                   const CancelToken& cancel) const;

private:
    double rounding_of_end(const RayEnd& end) const;

    const Plan& plan_;
    bool position_, rounding_;
    std::optional<Plan> second_run_;    ///< Plan of the second run. Set if position errors are requested.
    double error_over_difference_ = 1;  ///< Position error divided by the difference of the two ends.
};

/// Renders the film, including the layers `position_error` and `rounding_error` if the film has them.
RunReport render_with_errors(const Plan& plan, Film& film, const RunControl& control = {});

}  // namespace kagero
