/// Estimates of the errors of a picture's ray ends, from a second integration of the same rays.
#pragma once

#include "plan/variant.h"
#include "render/render.h"

namespace kagero {

/// Estimates the errors, in pixels, that the film layers `position_error` and `rounding_error` show. An error is zero
/// if the ray is captured in both runs. It is NaN if the two runs end with different statuses or on different objects,
/// or if the status is `step_limit` or `failed`.
///
/// Position error: a second run traces the rays in double with half the step, or with a hundredth of the tolerance. If
/// adaptive methods cannot meet a tolerance as small as that, the second run has a hundred times the tolerance. For a
/// method of order p, the difference of the ends times 2^p/(2^p − 1) is the error of the longer step (Richardson, Phil.
/// Trans. R. Soc. A 210, 1911). If the space bounds the step, half the step may change nothing, because the bound
/// already forces shorter steps. In that case, the second run uses an adaptive method of order 8 with a small
/// tolerance. The second run follows whole paths through surfaces, also with shorter steps in media.
///
/// Rounding error: a bound, see rounding_bounds.h.
class EndErrors {
public:
    /// Prepares the estimation of position errors if `position` is set, and of rounding errors if `rounding` is set.
    EndErrors(const Plan& plan, bool position, bool rounding);
    /// Returns the errors of the rays of a tile, in their order. The result is empty if neither error was
    /// requested in the constructor, and meaningless if `cancel` returned true.
    std::vector<EndError> estimate(const Tile& tile, const TracedRays& rays, const CancelToken& cancel) const;

private:
    double end_rounding_error(const RayEnd& end) const;

    const Plan& plan_;
    bool estimates_position_, estimates_rounding_;
    std::optional<Plan> second_run_;    ///< Plan of the second run. Empty if rays are straight and end at the first
                                        ///< surface, or if no position errors are requested.
    double error_over_difference_ = 1;  ///< Position error divided by the distance between the ends in both runs.
};

/// Renders the film, including the layers `position_error` and `rounding_error` if the film has them.
RunReport render_with_errors(const Plan& plan, Film& film, const RunControl& control = {});

}  // namespace kagero
