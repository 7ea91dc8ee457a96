/// The interaction of rays with surfaces that send light on: mirrors and boundaries of media.
///
/// At a surface with the normal n, the momentum changes only by a multiple of n: p' = p + α n. H of the side where the
/// ray continues determines α (kernels/interaction/normal_momentum.h). With the H of the other side, this is Snell's
/// law for that H; with the H of the same side, it is the law of reflection.
#pragma once

#include "appearance/path_state.h"
#include "paths/fresnel.h"
#include "plan/plan.h"

#include <optional>
#include <span>

namespace kagero {

/// A ray at a surface.
struct RayAtSurface {
    std::uint32_t medium;  ///< The medium of the ray (index of Plan::medium).
    const RayEnd* end;     ///< The end of its segment, in the coordinates of that medium.
    Double3 start;         ///< The start of its segment, in the same coordinates.
};

/// One way in which a ray can continue.
struct Branch {
    std::uint32_t medium = 0;
    Double3 position{}, momentum{};  ///< In the coordinates of that medium.
    double pt = 0;
    std::uint32_t surface = 0, primitive = 0;  ///< The surface on which the branch starts, and its triangle.
    double share = 0;                          ///< Share of the light that takes this branch.
    double radiance = 1;  ///< Ratio of the radiance before the surface, seen along the ray, to that of the branch.
};

/// The interaction of one ray with a surface. A branch is empty if the light cannot take it.
struct SurfaceInteraction {
    std::optional<Branch> reflected, transmitted;
    double frequency = 1;        ///< Factor that scales the ray's momentum to |p_t| = 1; 1 for rays without p_t.
    bool leaves_medium = false;  ///< The surface does not bound the medium of the ray on the side of the ray.

    /// Returns the stronger branch; null if the light cannot continue.
    const Branch* stronger() const;
    /// Returns the branch that a random number in [0, 1) selects, with the probability of its share; null if the light
    /// cannot continue.
    const Branch* sampled(double number) const;
};

/// Returns the interactions of rays with the surfaces that they hit. All of these surfaces send light on.
///
/// A boundary preserves the radiance divided by the squared index, times the share of the branch and the tint. The
/// index is |p|, divided by the frequency; in a spacetime, both are those of the rest frame of the surface, and the
/// index is 1. Null rays are first scaled to |p_t| = 1.
std::vector<SurfaceInteraction> interactions_of(const Plan& plan, std::span<const RayAtSurface> hits);

/// Returns the start of the ray that takes a branch.
RayStart start_of(const Plan& plan, const Branch& branch);

}  // namespace kagero
