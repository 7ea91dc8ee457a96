/// How rays end: their status and, if they fail, the reason.
#pragma once

#include <cstdint>

namespace kagero {

/// The result of a ray. Every ray ends with exactly one status.
enum class Status : std::uint8_t { hit, escaped, captured, step_limit, failed };
inline constexpr std::uint32_t status_count = 5;

/// The reason why a ray has the status `failed`; `none` for every other status.
enum class Failure : std::uint8_t {
    none,
    zero_direction,      ///< The direction has length zero.
    nonfinite_start,     ///< A coordinate of the start or the direction is infinite or NaN.
    singular_start,      ///< H or its derivatives do not exist at the start.
    too_far,             ///< The squares of the start's coordinates overflow the number type.
    no_observer,         ///< The space does not define this observer, or no such observer can exist at this position.
    no_rest_frame,       ///< H is not ½ g^ab p_a p_b with p_t > 0; directions of rays are those of dq/dλ instead.
    no_momentum,         ///< No real momentum has this direction and H = H0: inside a horizon, or where N² < 0.
    not_converged,       ///< A step has no solution, or none within its tolerance, at any step length.
    not_refined,         ///< The event that ends the last step could not be refined, at any step length.
    not_finite,          ///< The state overflows the number type, or Ω or the step bound is not greater than 0.
    bad_time_rescaling,  ///< Ω is not greater than 0 at the start.
    invalid_bounds,      ///< A formula's domain, capture or length_scale is NaN at the start, or length_scale is ≤ 0.
    untraced,            ///< The run was interrupted before this ray was traced.
    energy_lost,         ///< A step changes H too much, at any step length.
    needs_double,        ///< The momentum at the start is so large that float cannot represent H = H0.
    momentum_diverges,   ///< The momentum grows without bound, as at a horizon in coordinates that are singular there.
    steps_vanish,        ///< The steps become so short that the ray makes no progress.
    no_continuation,     ///< At a surface, no momentum on either side has H = H0.
    left_medium,         ///< The ray has left its medium without meeting the boundary of the medium.
    hamiltonian_jumps,   ///< The value of a formula jumps where a min, max, abs or where changes its branch.
};

inline constexpr std::uint32_t failure_count = 21;

}  // namespace kagero
