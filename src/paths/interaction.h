/// The interaction of rays with surfaces that send light on: mirrors, boundaries of media, and diffuse surfaces.
///
/// At a surface with the normal n, the momentum changes only by a multiple of n: p' = p + α n. H of the side where the
/// ray continues determines α (kernels/interaction/normal_momentum.h). With the H of the other side, this is Snell's
/// law for that H; with the H of the same side, it is the law of reflection.
#pragma once

#include "appearance/path_state.h"
#include "media/close_surfaces.h"
#include "paths/diffuse.h"
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
    std::optional<DiffusePoint> diffuse;  ///< Set at a diffuse surface, which has no branches.
    double frequency = 1;        ///< Factor that scales the ray's momentum to |p_t| = 1; 1 for rays without p_t.
    double index = 1, transmitted_index = 1;  ///< Refractive indices on the side of the ray, and beyond a boundary.
    bool leaves_medium = false;  ///< The surface does not bound the medium of the ray on the side of the ray.

    /// Makes all members those of a new object. This is faster than assigning one, which also clears unused memory.
    void reset() {
        reflected.reset();
        transmitted.reset();
        diffuse.reset();
        frequency = index = transmitted_index = 1;
        leaves_medium = false;
    }
    /// Returns the stronger branch; null if the light cannot continue.
    const Branch* stronger() const;
    /// Returns the branch that a random number in [0, 1) selects, with the probability of its share; null if the light
    /// cannot continue.
    const Branch* sampled(double number) const;
};

/// Computes the interactions of rays with surfaces. The object keeps its memory from call to call.
///
/// A boundary preserves the radiance divided by the squared index, times the share of the branch and the tint. The
/// index is |p|, divided by the frequency; in a spacetime, both are those of the rest frame of the surface, and the
/// index is 1. The indices are those at the boundary; MediumIndices takes into account that they vary in a medium. Null
/// rays are first scaled to |p_t| = 1.
class InteractionSolver {
public:
    explicit InteractionSolver(const Plan& plan);

    /// Returns the interactions of rays with the surfaces that they hit, all of which send light on. The result is
    /// valid until the next call.
    std::span<const SurfaceInteraction> solve(std::span<const RayAtSurface> hits);

private:
    /// A ray at a surface. Its branches are elements of `spaces_`.
    struct Crossing {
        double scale = 1;                      ///< Factor of the momentum, so that |p_t| = 1.
        std::uint32_t other_side = 0;          ///< The medium beyond a boundary.
        std::uint32_t reflected, transmitted;  ///< Indices of the rays in their spaces.
        bool is_boundary = false, is_diffuse = false, in_medium = true;
        bool passes_edge = false;  ///< The ray passes the edge of a boundary on the outside, by less than its rounding.
        /// Where boundaries touch, the one that the transmitted ray crosses last, and the way to it.
        std::optional<PointOnSurface> exit;
        Double3 to_exit{};
    };
    /// A momentum vector p_t g_ti/g_tt (Module::time_tilts); zero in a medium without p_t.
    struct TimeTilt {
        double vector[3] = {0, 0, 0};
    };
    /// The branches in one space, with the momenta of their incident rays. Those at boundaries are the first ones.
    struct SpaceRays {
        std::vector<SurfaceRay> rays;
        std::vector<TimeTilt> tilts;  ///< One for each branch at a boundary.
        std::vector<Continuation> continuations;
    };

    /// Sets the side of the ray and the media of a hit. Returns the reflected branch.
    SurfaceRay locate(const RayAtSurface& hit, Crossing& crossing) const;
    DiffusePoint diffuse_point(const RayAtSurface& hit, const SurfaceRay& ray) const;
    void set_media(const RayAtSurface& hit, const SurfaceRay& ray, bool is_outside, Crossing& crossing) const;
    /// Adds the branches at all boundaries, or those at all mirrors.
    void add_branches(std::span<const RayAtSurface> hits, bool at_boundaries);
    void compute_tilts();
    /// Converts the momenta of rays that pass between a spacetime and a medium without p_t.
    void convert_momenta(std::span<const RayAtSurface> hits);
    void compute_continuations();
    void set_interaction(const RayAtSurface& hit, const Crossing& crossing, SurfaceInteraction& interaction) const;
    void divide_light(std::uint32_t medium, const Crossing& crossing, Fresnel fresnel,
                      SurfaceInteraction& interaction) const;
    Branch branch_of(std::uint32_t medium, std::uint32_t index, const RayEnd& hit) const;
    std::uint32_t add_branch(std::uint32_t medium, const SurfaceRay& ray);
    double time_sign(std::uint32_t medium) const;

    const Plan& plan_;
    std::vector<SpaceRays> spaces_;  ///< One for each medium.
    std::vector<Crossing> crossings_;
    std::vector<SurfaceRay> reflected_;
    std::vector<SurfaceInteraction> interactions_;
};

/// Returns the start of the ray that takes a branch.
RayStart start_of(const Plan& plan, const Branch& branch);

}  // namespace kagero
