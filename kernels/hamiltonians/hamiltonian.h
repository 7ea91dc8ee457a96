/// What every Hamiltonian header is made of. One file in this directory, `some_name.h`, defines `struct SomeName`: the physics as
/// in the paper, generic in the number type V, with no derivative and no word of SIMD. The build finds it; nothing else changes.
///
/// A Hamiltonian provides
///   name, what, formula, source, conserved   texts for `kagero list`
///   parameters                               what a scene may set, with legal ranges
///   Parameters<V>                            the same, as members, in the same order
///   spacetime, level                         null rays with p_t (level 0), or an index medium started on H = level
///   method, step                             what a scene gets that asks for nothing
///   energy(k, q, p, pt)                      H
/// and, where there is something to say,
///   rescale(k, q)                            Ω > 0: Ω·(H − level) has the same rays, with steps that suit their scale
///   captured(k, q, v)                        the ray has ended inside where this is ≤ 0; v is along dq/dλ
///   domain(k, q)                             the medium ends, and the ray is escaped, where this is ≤ 0
///   part_a, part_b(k, q, p, pt)              two parts that sum to H: the paper's H_A and H_B, for the recipe as printed
///   flow_of_rest(k, q, p, pt, t)             the exact flow of H − ½(|p|² − p_t²), for the exact split
///   straight(k)                              these parameters leave every ray straight
#pragma once

#include "kernels/abi.h"
#include "kernels/numeric/quad.h"
#include "kernels/numeric/vec.h"

#include <array>
#include <limits>

namespace kagero::hamiltonians {

inline constexpr double unlimited = std::numeric_limits<double>::infinity();

}  // namespace kagero::hamiltonians
