/// The members of a Hamiltonian.
///
/// Each file `some_name.h` in this folder defines `struct SomeName`: the physics as in its source, generic in the
/// number type V, without derivatives and without SIMD code. The build finds the file; no other file needs to be
/// changed.
///
/// Required members:
///   name, what, formula, source, conserved
///                             texts for `kagero list`; `what` describes the space in one line.
///   parameters                parameters that a scene may set: name, default, minimum, maximum, true if the minimum
///                             is excluded, unit and description (`ParameterInfo`).
///   Parameters<V>             struct whose members are the values of the parameters, in the same order.
///   spacetime                 true if H describes light in a spacetime, where p_t is constant; false for a medium.
///   level                     H0, the value of H on all rays; 0 for a spacetime.
///   method, step              default integrator and default step.
///   energy(k, q, p, pt)       H at position q and momentum p; k contains the parameters and pt is p_t.
/// Optional members:
///   step_goes_with            length to which the default step is proportional: text of a formula in the parameters
///                             and escape_radius; omitted if the default step does not depend on a length.
///   index_parameter           name of the parameter that is a refractive index N. The default step is divided by N,
///                             because a step h in λ covers the length N h.
///   rescale(k, q)             Ω > 0 for time rescaling: with Ω·(H − level), a fixed step adapts to the length scale
///                             at q.
///   captured(k, q, p, v, pt)  ≤ 0 where a ray is captured; v has the direction of dq/dλ.
///   domain(k, q)              ≤ 0 outside the medium, where rays have escaped.
///   part_a, part_b(k, q, p, pt)
///                             H_A and H_B, two parts with the sum H (Satoh 2003, eq. 10). They are used only by
///                             the recipe as printed (kernels/recipe).
///   remainder_flow(k, q, p, pt, t)
///                             advances q and p by the exact flow of H − ½(|p|² − p_t²); λ increases by t.
///   straight(k)               true if every ray is straight for the parameters k.
///   bending_radius(k)         distance from the origin beyond which rays are straight, so that one step is enough.
///   switching_function(k, q)  changes sign where H or its derivatives jump: steps end there.
///   max_step_length(k, q)     bound on the length |h dq/dλ| of a step h that starts at q, so that no step jumps over a
///                             thin structure.
///   orbit_potential(k, u, g)  for a spherically symmetric H, the potential V(u) in the orbit plane: ½ (du/dφ)² + V is
///                             constant, where φ is the angle in the plane, u = 1/r and V(0) = 0. b is the impact
///                             parameter: g = 1/b² is (p_t/L)² in a spacetime and 1/L² in a medium; L = |x × p|.
///   orbit_delay(k, u)         with orbit_potential: L dλ/dφ − r²; default: 0.
///   radial_momentum(k, u, v, L, pt)
///                             with orbit_potential: p·x/r, from v = −L du/dφ; default: v.
///   orbit_method, orbit_step  with orbit_potential or separated_hole: default integrator and step (radians) instead of
///                             method and step.
///   throat_radius(k)          radius of the sphere at the throat of a wormhole. The points inside the sphere represent
///                             the second sheet; inversion at the sphere exchanges the sheets.
///   separated_hole(k)         mass GM/c² and spin a of the hole around which the motion of null rays separates in Mino
///                             time, as in Kerr–Schild coordinates of the Kerr spacetime. Also needed are radius(k, q)
///                             and radial_polynomial_bound(A, B, C, p_t², r₊/r), positive only if the radial potential
///                             is positive down to the horizon (kerr.h).
///   hole(k)                   mass GM/c² and spin a = J/(Mc) of the black hole at the origin, both lengths.
///   radius(k, q), time_offset_gradient(k, r), infall(k, r)
///                             functions for observers near a black hole; schwarzschild.h defines their meaning.
///
/// A medium with the refractive index N and H = ½(|p|² − N²) inherits from `IndexMedium`, and defines
/// index_squared(k, q), which returns N², instead of energy.
#pragma once

#include "kernels/abi.h"
#include "kernels/numeric/quad.h"
#include "kernels/operation.h"
#include "kernels/numeric/vec.h"

#include <array>
#include <limits>

namespace kagero::hamiltonians {

/// Limit of a parameter that has no minimum (with a minus sign) or no maximum.
inline constexpr double unlimited = std::numeric_limits<double>::infinity();

/// The mass GM/c² and the spin a = J/(Mc) of a black hole, both lengths.
template <class V>
struct MassAndSpin {
    V mass, spin;
};

/// Base class of media with the refractive index N(q): H = ½(|p|² − N²), H0 = 0. Then dq/dλ = p, and the arc length is
/// ds = N dλ (Born & Wolf, §3.2; Satoh 2003, eq. 5, uses the arc length).
template <class Medium>
struct IndexMedium {
    static constexpr bool spacetime = false;
    static constexpr double level = 0;
    static constexpr const char* method = "srkn6";

    template <class Parameters, class V>
    static constexpr V energy(const Parameters& k, const Vec3<V>& q, const Vec3<V>& p, const V&) {
        return 0.5 * (dot(p, p) - Medium::index_squared(k, q));
    }
    template <class Parameters, class V>
    static constexpr V part_a(const Parameters&, const Vec3<V>&, const Vec3<V>& p, const V&) {
        return 0.5 * dot(p, p);
    }
    template <class Parameters, class V>
    static constexpr V part_b(const Parameters& k, const Vec3<V>& q, const Vec3<V>&, const V&) {
        return -0.5 * Medium::index_squared(k, q);
    }
};

}  // namespace kagero::hamiltonians
