/// The surfaces that rays have hit, and the test whether a segment departs from a surface rather than hitting it.
#pragma once

#include "kernels/intersection/surface.h"

#include <cstdint>

namespace kagero {

/// The surfaces that the lanes of a packet have hit.
template <class V>
struct SurfaceHits {
    std::uint32_t surface[lane_count<V>] = {}, primitive[lane_count<V>] = {};
    V piece_start{ScalarOf<V>(0)}, piece_end{ScalarOf<V>(0)};  ///< Ends of the hit piece, as fractions of the step.
    V t{ScalarOf<V>(0)};  ///< Embree's position of the hit, as a fraction of the chord of that piece.
    std::uint64_t departing = 0;  ///< Lanes whose hit piece begins on the named surface where the ray starts.

    /// Returns the approximate position of the hit, as a fraction of the step.
    V hit_fraction() const { return fma(t, piece_end - piece_start, piece_start); }
};

/// Returns the lanes in which a → b departs from the surface that the query has found at `fraction`, rather than
/// hitting it. Such a segment starts on the surface or moves away from it. A segment that starts on a sphere departs
/// from it only if the segment does not meet the sphere again beyond the fraction `least`. In lanes of
/// `may_start_on_surface`, a start within `rounding` of the surface counts as a start on the surface.
template <class T>
MaskOf<T> departs(const LevelSet<T>& g, const Vec3<T>& a, const Vec3<T>& b, const T& fraction, const T& least,
                  const T& rounding, const MaskOf<T>& may_start_on_surface) {
    const T zero(0), height = g.value(a), away = height * g.slope(a, b - a);
    const MaskOf<T> on_surface = may_start_on_surface & (abs(height) <= rounding);
    const MaskOf<T> from_plane = on_surface | (away >= zero),
                    from_sphere = (fraction <= zero) | (on_surface & (fraction <= least));
    return ((abs(g.a) <= zero) & from_plane) | ((abs(g.a) > zero) & from_sphere);
}

}  // namespace kagero
