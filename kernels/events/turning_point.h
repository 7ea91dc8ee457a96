/// The radial turning point of a ray that approaches the escape sphere from outside and passes it without entering.
/// Such a ray escapes at its point nearest to the origin. On the second sheet of a wormhole, where "outward" means
/// towards the origin, it escapes at its point farthest from the origin.
#pragma once

#include "kernels/events/escape_sphere.h"

namespace kagero {

/// The ray passes the escape sphere at its turning point.
struct TurningPoint : ValueEvent<TurningPoint> {
    static constexpr Status status = Status::escaped;
    static constexpr bool may_follow_another = false;  // The whole step lies outside the escape sphere.

    template <class V>
    static bool exists(const Task<V>&) {
        return true;
    }
    /// Returns no lane: this event is possible only where the quick test of an escape sphere succeeds. `crossed` is
    /// then evaluated for all events.
    template <class V>
    KAGERO_INLINE static MaskOf<V> possible(const Task<V>&, const Step<V>&, const V&) {
        return no_lanes<V>();
    }
    template <class V>
    static MaskOf<V> crossed(const Task<V>& task, const Step<V>& step) {
        MaskOf<V> leaves = EscapeSphere::crossed(task, step);
        if (SecondEscapeSphere::exists(task)) leaves = leaves | SecondEscapeSphere::crossed(task, step);
        if (!any(leaves)) return leaves;
        const V inner2 = SecondEscapeSphere::squared_radius(task), outer2 = EscapeSphere::squared_radius(task);
        const Vec3<V> a = step.start.q(), b = step.end.q(), chord = b - a;
        const V along = dot(a, chord),
                nearest2 = dot(a, a) - along * along / dot(chord, chord);  // smallest |q|² on the infinite line
        const MaskOf<V> on_second_sheet = (dot(a, a) < inner2) & (dot(b, b) < inner2);
        const MaskOf<V> passes = ((dot(a, a) > outer2) & (nearest2 > outer2)) | on_second_sheet;
        return leaves & passes;
    }
    template <class V>
    static MaskOf<V> starts_beyond(const Task<V>&, const RayState<V>&) {
        return no_lanes<V>();
    }
    template <class V>
    static MaskOf<V> crossed_before(const Task<V>&, const RayState<V>&, const RayState<V>&) {
        return no_lanes<V>();
    }
    /// Returns q·dq/dτ, with the sign that makes it positive at the start of the step.
    template <class V>
    static V value(const RayState<V>& start, const RayState<V>& at) {
        const V rate = dot(at.q(), at.velocity);
        return select(dot(start.q(), start.velocity) > V(ScalarOf<V>(0)), rate, -rate);
    }
};

}  // namespace kagero
