/// Dense output of one step: the cubic Hermite curve through both ends with both velocities, in Bézier form.
#pragma once

#include "kernels/stepping/implicit.h"

namespace kagero {

/// √x to a few roundings, without the slow instruction; 0 at 0.
template <class V>
KAGERO_INLINE V root(const V& x) { return x * rsqrt(max(x, V(std::numeric_limits<ScalarOf<V>>::min()))); }

template <class V>
struct Curve {
    Vec3<V> q0, b1, b2, q1;

    KAGERO_INLINE static Curve of_step(const Leg<V>& f) {
        const V third = f.h * V(ScalarOf<V>(1.0 / 3));
        return {f.start.q(), advance(f.start.q(), third, f.start_velocity), retreat(f.end.q(), third, f.end_velocity), f.end.q()};
    }
    /// At the fraction s of the step; exact at 0 and 1.
    KAGERO_INLINE Vec3<V> at(const V& s) const {
        using S = ScalarOf<V>;
        const V t = V(S(1)) - s, w0 = t * t * t, w1 = V(S(3)) * (t * t) * s, w2 = V(S(3)) * t * (s * s), w3 = s * s * s;
        return advance(advance(advance(w0 * q0, w1, b1), w2, b2), w3, q1);
    }
    /// d/ds.
    KAGERO_INLINE Vec3<V> slope(const V& s) const {
        using S = ScalarOf<V>;
        const V t = V(S(1)) - s, w0 = V(S(3)) * (t * t), w1 = V(S(6)) * t * s, w2 = V(S(3)) * (s * s);
        return advance(advance(w0 * (b1 - q0), w1, b2 - b1), w2, q1 - b2);
    }
    /// An upper bound of the distance between curve and chord: ¾ of the inner control points' distances from the chord, with a tenth
    /// to spare.
    KAGERO_INLINE V sagitta() const {
        using S = ScalarOf<V>;
        const Vec3<V> chord = q1 - q0;
        const V inverse = recip(max(dot(chord, chord), V(S(std::numeric_limits<float>::min()))));
        const auto off = [&](const Vec3<V>& b) {
            const Vec3<V> e = b - q0;
            const V along = dot(e, chord);
            return dot(e, e) - along * along * inverse;
        };
        return V(S(0.75 * 1.1)) * root(max(max(off(b1), off(b2)), V(S(0))));
    }
    /// Greatest distance of any point of a step's curve from its start, bounded by its control points.
    KAGERO_INLINE static V reach(const Leg<V>& f) {
        const V third = f.h * V(ScalarOf<V>(1.0 / 3));
        const Vec3<V> way = f.end.q() - f.start.q(), last = retreat(way, third, f.end_velocity);
        const V first = third * third * dot(f.start_velocity, f.start_velocity);
        return root(max(max(first, dot(last, last)), dot(way, way)));
    }
};

}  // namespace kagero
