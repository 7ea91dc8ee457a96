/// The starts of rays, which the program and the kernels share.
#pragma once

#include "kernels/ray_status.h"
#include "kernels/surfaces.h"

#include <cstdint>

namespace kagero {

/// The position and momentum at the start of a ray.
struct RayStart {
    double q[3], p[3], pt;
    Failure failure;           ///< If not `none`, the ray ends at its start as `failed`.
    bool captured;             ///< The ray ends at its start as `captured`: no light comes from this direction.
    bool escaped;              ///< The ray ends at its start as `escaped`: it moves outward beyond the escape sphere.
    bool ingoing = false;      ///< The state is that of a ray in ingoing coordinates (kernels/observers/charts.h).
    std::uint32_t medium = 0;  ///< Medium in which the ray starts (Plan::medium); kernels do not read it.
    /// The surface on which the ray starts, and its triangle; `no_surface`: none is known. The position must lie on the
    /// triangle or sphere up to rounding. The direction states the side on which the ray leaves it. The rules for other
    /// surfaces close to the start are those of kernels/events/surface_starts.h.
    std::uint32_t surface = no_surface, primitive = 0;
};

/// What the starts of rays with one position share. The momentum of a ray with ∂H/∂p = μe and H = H0 is
/// p = G⁻¹(μe − v0), where G is the spatial block of ∂²H/∂p_a∂p_b, and v0 is ∂H/∂p at p = 0. For formulas, only q is
/// set.
struct StartPosition {
    double q[3];
    double pt;                   ///< p_t of the rays.
    double inverse_block[3][3];  ///< G⁻¹
    double velocity[3];          ///< v0
    double scaled_square;        ///< μ² eᵀG⁻¹e, the same for all directions e.
    Failure failure;             ///< If not `none`, no ray can start here.
};

}  // namespace kagero
