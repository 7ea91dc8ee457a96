/// The members of a Hamiltonian.
///
/// Each file `some_name.h` in this folder defines `struct SomeName`: the physics as in its source, generic in the
/// number type V, without derivatives and without SIMD code. The build finds the file; no other file needs to be
/// changed.
///
/// Required members:
///   name, what, formula, source, conserved
///                             texts for `kagero list`.
///   parameters                parameters that a scene may set, with units and legal ranges.
///   Parameters<V>             values of the parameters as members, in the same order.
///   spacetime, level          true: null rays with constant p_t (level 0); false: an index medium on H = level.
///   method, step              default integrator and default step.
///   energy(k, q, p, pt)       H.
/// Optional members:
///   step_goes_with            length to which the default step is proportional: text of a formula in the parameters
///                             and escape_radius; omitted if the default step does not depend on a length.
///   index_parameter           refractive index N to whose inverse the default step is proportional: the length of a
///                             step is N times its λ.
///   rescale(k, q)             Ω > 0 for time rescaling: steps of Ω·(H − level) adapt to the length scale at q.
///   captured(k, q, p, v, pt)  ≤ 0 where a ray is captured; v has the direction of dq/dλ.
///   domain(k, q)              ≤ 0 outside the medium, where rays have escaped.
///   part_a, part_b(k, q, p, pt)
///                             two parts with the sum H: H_A and H_B of the recipe as printed (Satoh 2003, eq. 10).
///   remainder_flow(k, q, p, pt, t)
///                             advances q and p by the exact flow of H − ½(|p|² − p_t²) over the time t.
///   straight(k)               true if these parameters make every ray straight.
///   bending_radius(k)         distance from the origin beyond which rays are straight, so that one step is enough.
///   switching_function(k, q)  changes sign where H or its derivatives jump: steps end there.
///   max_step_length(k, q)     bound on the length of a step, so that no step jumps over a thin structure.
///   orbit_potential(k, u, g)  for a spherical H, the potential V(u) in the orbit plane: ½ (du/dφ)² + V is constant,
///                             with u = 1/r and V(0) = 0. g = 1/b² is (p_t/L)² in a spacetime and 1/L² in a medium,
///                             where L = |x × p|.
///   orbit_delay(k, u)         with orbit_potential: L dλ/dφ − r²; default: 0.
///   radial_momentum(k, u, v, L, pt)
///                             with orbit_potential: p·x/r, from v = −L du/dφ; default: v.
///   orbit_method, orbit_step  with orbit_potential: default integrator and step (radians) instead of method and step.
///   throat_radius(k)          radius of the sphere inside which the second sheet is, as the image of the first sheet
///                             by inversion.
///   hole(k)                   mass and spin of the black hole at the origin.
///   radius(k, q), time_offset_gradient(k, r), infall(k, r)
///                             functions for the observers of a black hole; see schwarzschild.h.
///
/// A medium of index N, H = ½(|p|² − N²), inherits from `IndexMedium` and defines index_squared(k, q) instead of
/// energy.
#pragma once

#include "kernels/abi.h"
#include "kernels/numeric/quad.h"
#include "kernels/operation.h"
#include "kernels/numeric/vec.h"

#include <array>
#include <limits>

namespace kagero::hamiltonians {

inline constexpr double unlimited = std::numeric_limits<double>::infinity();

/// A medium of refractive index N(q): H = ½(|p|² − N²) on H = 0. Then dq/dτ = p, and the arc length is ds = N dτ (Born
/// & Wolf, §3.2; Satoh 2003, eq. 5, uses the arc length).
template <class Medium>
struct IndexMedium {
    static constexpr bool spacetime = false;
    static constexpr double level = 0;
    static constexpr const char* method = "srkn6";

    template <class K, class V>
    static constexpr V energy(const K& k, const Vec3<V>& q, const Vec3<V>& p, const V&) {
        return 0.5 * (dot(p, p) - Medium::index_squared(k, q));
    }
    template <class K, class V>
    static constexpr V part_a(const K&, const Vec3<V>&, const Vec3<V>& p, const V&) {
        return 0.5 * dot(p, p);
    }
    template <class K, class V>
    static constexpr V part_b(const K& k, const Vec3<V>& q, const Vec3<V>&, const V&) {
        return -0.5 * Medium::index_squared(k, q);
    }
};

}  // namespace kagero::hamiltonians
