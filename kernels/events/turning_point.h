/// The turning point of a ray that passes the escape sphere from outside without entering it: it has escaped where it
/// is nearest to the origin. (On the second sheet of a wormhole: where it is farthest from it.)
#pragma once

#include "kernels/events/escape_sphere.h"

namespace kagero {

struct TurningPoint : ValueEvent<TurningPoint> {
    static constexpr Status status = Status::escaped;
    static constexpr bool may_follow_another = false;  // the whole step lies outside of the scene

    template <class V>
    static bool exists(const Task<V>&) {
        return true;
    }
    /// Not tested by itself: the event is possible only where a sphere's quick test succeeds, and then `crossed`
    /// decides.
    template <class V>
    KAGERO_INLINE static MaskOf<V> possible(const Task<V>&, const Step<V>&, const V&) {
        return never<V>();
    }
    template <class V>
    static MaskOf<V> crossed(const Task<V>& task, const Step<V>& step) {
        MaskOf<V> leaves = EscapeSphere::crossed(task, step);
        if (SecondEscapeSphere::exists(task)) leaves = leaves | SecondEscapeSphere::crossed(task, step);
        if (!any(leaves)) return leaves;
        const V inner2 = SecondEscapeSphere::squared_radius(task), outer2 = EscapeSphere::squared_radius(task);
        const Vec3<V> a = step.start.q(), b = step.end.q(), way = b - a;
        const V along = dot(a, way),
                nearest2 = dot(a, a) - along * along / dot(way, way);  // of the whole straight line
        const MaskOf<V> on_second_sheet = (dot(a, a) < inner2) & (dot(b, b) < inner2);
        const MaskOf<V> passes = ((dot(a, a) > outer2) & (nearest2 > outer2)) | on_second_sheet;
        return leaves & passes;
    }
    template <class V>
    static MaskOf<V> starts_beyond(const Task<V>&, const RayState<V>&) {
        return never<V>();
    }
    template <class V>
    static MaskOf<V> crossed_before(const Task<V>&, const RayState<V>&, const RayState<V>&) {
        return never<V>();
    }
    /// The speed along the radius, > 0 in the direction that the ray had at the start of the step.
    template <class V>
    static V value(const RayState<V>& start, const RayState<V>& at) {
        const V speed = dot(at.q(), at.velocity);
        return select(dot(start.q(), start.velocity) > V(ScalarOf<V>(0)), speed, -speed);
    }
};

}  // namespace kagero
