/// The interface of events. An event ends a ray, ends a step, or changes the state of a ray.
///
/// Each event is one struct of static functions and constants in one file, and one row of the list in all_events.h. It
/// has these members:
///   effect                       the effect of the event on a ray.
///   status                       for Effect::end: the status of rays that end at the event.
///   resume(task, at, lanes)      for Effect::resume: changes the states of `lanes` at the event into those with which
///                                their rays continue.
///   exists(task)                 true if the space, the scene or the job has this event; other events cost nothing.
///   possible(task, step, steps)  a quick test of the end of a step; returns the lanes that may have crossed the event.
///                                `steps` is the number of steps of each ray. If the quick tests of all events fail in
///                                all lanes, no further test is made. SurfaceHit and Discontinuity have no quick test;
///                                other classes detect them.
///   crossed(task, step)          returns the lanes whose step has crossed the event. It is evaluated if the quick test
///                                of any event has succeeded. Default: `possible`.
///   applies_to(step)             returns the lanes in which the event can take place; default: all lanes.
///   starts_beyond(task, start)   returns the lanes whose ray starts beyond the event; such a ray ends at its start.
/// The point of an event is the end of its step, or it is found within the step by one of two functions:
///   value(start, at)             a function of the state `at` on a step that begins at `start`; positive before the
///                                event. The secant method finds its zero. All trial steps begin at `start`, because
///                                the state beyond the event may be undefined.
///   level_set(task)              a plane or a sphere. Newton's method finds its intersection with the dense output;
///                                correction steps then move the ray onto it. SurfaceHit has no such function: its
///                                level set is the surface that was hit.
/// An event with one of these two functions also has this function:
///   crossed_before(task, start, at)  returns the lanes in which the event lies between the start of a step and the
///                                    point `at`, which is the point of another event.
/// An event with a `value` may override these constants of ValueEvent:
///   may_follow_another           true if another event may precede this event on the same step.
///   ends_if_unrefined            true if a ray ends at the end of its whole step when refinement fails.
/// An event at the end of a step may have `finish(task, step, lanes)`, which removes a rounding error there. An event
/// on a sphere may have `moves_back(at)`, which returns the lanes whose velocity at the refined event points inward.
/// `ValueEvent` derives all tests from `value`; a derived event needs only `status`, `exists` and `value`.
#pragma once

#include "kernels/intersection/surface.h"
#include "kernels/methods/task.h"

#include <cstdint>
#include <type_traits>

namespace kagero {

/// The effect of an event on a ray.
enum class Effect : std::uint8_t {
    end,     ///< The ray ends at the event.
    split,   ///< The step ends at the event, and the next step starts there.
    resume,  ///< The ray continues from the event with another state.
};

/// Base of an event that has a `value`. `Event` is the derived struct.
template <class Event>
struct ValueEvent {
    static constexpr Effect effect = Effect::end;
    /// True if another event may precede this event on the same step.
    static constexpr bool may_follow_another = true;
    /// True if a ray ends at the end of its whole step when the refinement of the event fails.
    static constexpr bool ends_if_unrefined = false;

    template <class V>
    KAGERO_INLINE static MaskOf<V> possible(const Task<V>&, const Step<V>& step, const V&) {
        return !(Event::value(step.start, step.end) > V(ScalarOf<V>(0)));
    }
    template <class V>
    KAGERO_INLINE static MaskOf<V> crossed(const Task<V>&, const Step<V>& step) {
        return Event::value(step.start, step.end) <= V(ScalarOf<V>(0));
    }
    template <class V>
    static MaskOf<V> starts_beyond(const Task<V>&, const RayState<V>& start) {
        return Event::value(start, start) <= V(ScalarOf<V>(0));
    }
    template <class V>
    static MaskOf<V> crossed_before(const Task<V>&, const RayState<V>& start, const RayState<V>& at) {
        return Event::value(start, at) < V(-value_uncertainty<ScalarOf<V>>) * abs(Event::value(start, start));
    }

    /// Uncertainty of the value at a refined event, as a fraction of the value at the start of the step.
    template <class S>
    static constexpr S value_uncertainty = std::is_same_v<S, float> ? S(1e-5) : S(1e-10);
};

/// Returns the lanes in which an event can take place.
template <class Event, class V>
std::uint64_t applicable_lanes(const Step<V>& step) {
    if constexpr (requires { Event::applies_to(step); }) return to_bits(Event::applies_to(step));
    else return ~std::uint64_t(0);
}

/// True for events whose point is a zero of the function `value`.
template <class Event, class V>
concept HasValue = requires(const RayState<V>& at) {
    Event::value(at, at);
};
/// True for events whose point lies on the surface that the function `level_set` returns.
template <class Event, class V>
concept HasLevelSet = requires(const Task<V>& task) {
    Event::level_set(task);
};

}  // namespace kagero
