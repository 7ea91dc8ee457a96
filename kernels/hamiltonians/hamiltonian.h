/// What every Hamiltonian header is made of. One file in this directory, `some_name.h`, defines `struct SomeName`: the
/// physics as in the paper, generic in the number type V, with no derivative and no word of SIMD. The build finds it;
/// nothing else changes.
///
/// A Hamiltonian provides
///   name, what, formula, source, conserved   texts for `kagero list`
///   parameters                               what a scene may set, with legal ranges
///   Parameters<V>                            the same, as members, in the same order. The unit of each is a `Unit`: a number, or a power of
///                                            length, by which parameters are scaled when a scene is measured in another unit of length
///   spacetime, level                         null rays with p_t (level 0), or an index medium started on H = level
///   method, step                             what a scene gets that asks for nothing
///   energy(k, q, p, pt)                      H
/// and, where there is something to say,
///   step_goes_with                           the length that the default step goes with, in the parameters and escape_radius, as formulas
///                                            of scenes are written; nothing where no parameter is one, or a rescaling sees to it
///   index_parameter                          the index of refraction whose inverse it goes with: a step is N times as long as its λ
///   rescale(k, q)                            Ω > 0: Ω·(H − level) has the same rays, with steps that suit their scale
///   captured(k, q, p, v, pt)                 the ray has ended inside where this is ≤ 0; v is along dq/dλ
///   domain(k, q)                             the medium ends, and the ray is escaped, where this is ≤ 0
///   part_a, part_b(k, q, p, pt)              two parts that sum to H: the paper's H_A and H_B, for the recipe as printed
///   remainder_flow(k, q, p, pt, t)           the exact flow of H − ½(|p|² − p_t²), for the exact split
///   straight(k)                              these parameters leave every ray straight
///   bends_within(k)                          beyond this distance from the origin rays of H are straight: one step goes all the way
///   switching_function(k, q)                 changes sign where the slope of H jumps: steps end there
///   max_step_length(k, q)                    no step is longer than this, so that none leaps over what is thin
///   orbit_potential(k, u, g)                 a spherical H: V(u) of the orbit, ½ (du/dφ)² + V, u = 1/r, V(0) = 0; g = 1/b² is
///                                            (p_t/L)² in a spacetime, 1/L² in a medium, L = |x × p|
///   orbit_delay(k, u)                        … by how much L dλ/dφ is more than r²
///   radial_momentum(k, u, v, L, pt)          … and p·x/r from v = −L du/dφ, where that is not v
///   orbit_method, orbit_step                 … and what then is taken instead of method and step, radians
///   throat_radius(k)                         there is a second sheet inside a sphere of this radius, the image of this one by inversion
///   hole(k)                                  the hole at the origin, which matter orbits
///   radius(k, q), time_offset_gradient(k, r), infall(k, r)
///                                            what the observers of a hole need; see schwarzschild.h
///
/// A medium of index N, H = ½(|p|² − N²), inherits from `IndexMedium` and states index_squared(k, q) alone.
#pragma once

#include "kernels/abi.h"
#include "kernels/numeric/quad.h"
#include "kernels/operation.h"
#include "kernels/numeric/vec.h"

#include <array>
#include <limits>

namespace kagero::hamiltonians {

inline constexpr double unlimited = std::numeric_limits<double>::infinity();

/// H = ½(|p|² − N²(q)) on H = 0, where dq/dτ = p and τ has ds = N dτ (Born & Wolf, §3.2; Satoh 2003, eq. 5 in arc
/// length).
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
