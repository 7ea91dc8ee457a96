/// The escape sphere around the origin: a ray that leaves through it escapes. A wormhole has a second, inner escape
/// sphere for its second sheet, where "outward" means towards the origin.
#pragma once

#include "kernels/events/event.h"

namespace kagero {

/// Escape through the sphere of radius `escape_radius`, or through the inner sphere of the second sheet.
template <bool inner>
struct SphereEvent {
    static constexpr Effect effect = Effect::end;
    static constexpr Status status = Status::escaped;

    template <class V>
    static bool exists(const Task<V>& task) {
        return !inner || task.job.inner_escape_radius > 0;
    }
    template <class V>
    KAGERO_INLINE static const V& radius(const Task<V>& task) {
        return inner ? task.inner_escape_radius : task.escape_radius;
    }
    template <class V>
    KAGERO_INLINE static V squared_radius(const Task<V>& task) {
        return radius(task) * radius(task);
    }
    /// Returns the lanes whose position lies on the sphere or beyond it.
    template <class V>
    KAGERO_INLINE static MaskOf<V> is_reached(const Task<V>& task, const Vec3<V>& q) {
        if constexpr (inner) return dot(q, q) <= squared_radius(task);
        else return dot(q, q) >= squared_radius(task);
    }
    /// Returns the lanes whose position lies strictly beyond the sphere.
    template <class V>
    KAGERO_INLINE static MaskOf<V> is_beyond(const Task<V>& task, const Vec3<V>& q) {
        if constexpr (inner) return dot(q, q) < squared_radius(task);
        else return dot(q, q) > squared_radius(task);
    }
    /// Returns the lanes in which v at q points outward: away from the origin, or towards it for the inner sphere.
    template <class V>
    KAGERO_INLINE static MaskOf<V> moves_outward(const Vec3<V>& q, const Vec3<V>& v) {
        if constexpr (inner) return dot(q, v) < V(ScalarOf<V>(0));
        else return dot(q, v) >= V(ScalarOf<V>(0));
    }
    /// Returns the lanes in which q lies on the sphere or beyond it and v points outward: the ray has left.
    template <class V>
    KAGERO_INLINE static MaskOf<V> has_left(const Task<V>& task, const Vec3<V>& q, const Vec3<V>& v) {
        return is_reached(task, q) & moves_outward(q, v);
    }

    template <class V>
    KAGERO_INLINE static MaskOf<V> possible(const Task<V>& task, const Step<V>& step, const V&) {
        return is_reached(task, step.end.q());
    }
    /// Returns the lanes whose step ends on the sphere or beyond it, except rays that started beyond it and still move
    /// inward.
    template <class V>
    static MaskOf<V> crossed(const Task<V>& task, const Step<V>& step) {
        const Vec3<V> q = step.end.q();
        return is_reached(task, q) & (moves_outward(q, step.end.velocity) | !is_beyond(task, step.start.q()));
    }
    template <class V>
    static MaskOf<V> starts_beyond(const Task<V>& task, const RayState<V>& start) {
        return has_left(task, start.q(), start.velocity);
    }

    template <class V>
    static LevelSet<V> level_set(const Task<V>& task) {
        return sphere_level_set(radius(task));
    }
    /// Returns the lanes whose velocity at the refined event points inward. There, the ray enters the sphere again; it
    /// has left the sphere earlier.
    template <class V>
    static MaskOf<V> moves_back(const RayState<V>& at) {
        const V rate = dot(at.q(), at.velocity);
        return (inner ? -rate : rate) < V(ScalarOf<V>(0));
    }
    template <class V>
    static MaskOf<V> crossed_before(const Task<V>& task, const RayState<V>& start, const RayState<V>& at) {
        using S = ScalarOf<V>;
        constexpr S uncertainty = ValueEvent<SphereEvent>::template value_uncertainty<S>;
        const Vec3<V> a = start.q(), q = at.q();
        const V square = squared_radius(task);
        if constexpr (inner) return (dot(a, a) > square) & (dot(q, q) < V(S(1 - uncertainty)) * square);
        else return (dot(a, a) < square) & (dot(q, q) > V(S(1 + uncertainty)) * square);
    }
};

using EscapeSphere = SphereEvent<false>;
using SecondEscapeSphere = SphereEvent<true>;

/// Returns the lanes whose position lies beyond one of the escape spheres.
template <class V>
MaskOf<V> is_outside(const Task<V>& task, const Vec3<V>& q) {
    return EscapeSphere::is_beyond(task, q) | SecondEscapeSphere::is_beyond(task, q);
}
/// Returns the lanes whose ray at q with velocity v has left through an escape sphere.
template <class V>
MaskOf<V> has_left_scene(const Task<V>& task, const Vec3<V>& q, const Vec3<V>& v) {
    const MaskOf<V> left = EscapeSphere::has_left(task, q, v);
    return SecondEscapeSphere::exists(task) ? left | SecondEscapeSphere::has_left(task, q, v) : left;
}

/// A part of a step that lies outside the escape sphere although both ends of the step lie inside.
template <class V>
struct Excursion {
    V exit;      ///< Fraction of the step at which the ray leaves the sphere.
    V farthest;  ///< Fraction of the step at which the ray is farthest from the origin.
};

/// Returns those of `lanes` that leave the escape sphere during their step and return, and sets their `excursion`. In
/// all `lanes`, the ray must move outward at the start of the step and inward at its end.
template <class V>
std::uint64_t find_excursions(const Task<V>& task, const StepperState<V>& step, std::uint64_t lanes,
                              Excursion<V>& excursion) {
    using S = ScalarOf<V>;
    const V radius2 = EscapeSphere::squared_radius(task), zero(S(0)), one(S(1)), half(S(0.5));
    const Vec3<V> a = step.start.q(), b = step.end.q();
    lanes &= to_bits((dot(a, a) < radius2) & (dot(b, b) < radius2));
    if (!lanes) return 0;
    const Curve<V> curve = task.curve(step);
    lanes &= to_bits(curve.max_radius2() > radius2);
    if (!lanes) return 0;
    // Returns an upper bound on the root between 0 and `greatest`, by bisection. Its error is at most greatest / 4096.
    const auto bisect = [&](const V& greatest, const auto& is_below_root) {
        V lower = zero, upper = greatest;
        for (int i = 0; i < 12; ++i) {
            const V middle = half * (lower + upper);
            const MaskOf<V> below = is_below_root(middle);
            lower = select(below, middle, lower);
            upper = select(below, upper, middle);
        }
        return upper;
    };
    const auto square = [&](const V& s) {
        const Vec3<V> q = curve.at(s);
        return dot(q, q);
    };
    excursion.farthest = bisect(one, [&](const V& s) { return dot(curve.at(s), curve.slope(s)) > zero; });
    excursion.exit = bisect(excursion.farthest, [&](const V& s) { return square(s) < radius2; });
    return lanes & to_bits(square(excursion.farthest) > radius2);
}

}  // namespace kagero
