/// What an event is: something on a step at which a ray ends, or at which a step has to end.
///
/// An event is a struct of static functions and constants in a file of its own, and a row of the list in all_events.h:
///   effect                       what happens to a ray at the event
///   status                       Effect::end: the status of rays that end here
///   resume(task, at)             Effect::resume: changes the state at the event into the one that the ray goes on with
///   exists(task)                 whether the space, the scene or the job has this event; if not, nothing looks for it
///   possible(task, step, steps)  a quick test at the end of a step, for all lanes. If no quick test succeeds in any lane,
///                                no event is looked for; an event without one is found in a way of its own (SurfaceHit)
///   crossed(task, step)          the exact test, evaluated if some quick test succeeded; default: `possible`
///   starts_beyond(task, start)   whether a ray that starts here is beyond the event already, and ends at once
/// An event lies at the end of its step, or it is found within the step in one of two ways:
///   value(start, at)             a function of the state that is > 0 before the event. The secant method finds its zero,
///                                with steps that all begin at the start of the step: the state beyond has no meaning
///   level(task)                  a plane or a sphere. Newton's method finds it on the dense output, and short steps
///                                correct the place
/// Such an event also has
///   crossed_before(task, start, at)  whether the event lies between the start of a step and the place of another event
/// and, where they differ from those of ValueEvent,
///   may_follow_another           whether another event may lie before it on the same step
///   certain                      whether its rays end at the end of the whole step if the event cannot be refined
/// An event at the end of a step may have `finish(task, step, lanes)`, which removes a rounding there; an event on a
/// sphere may have `moves_back(at)`, which is true where a refined ray must have left the sphere earlier.
/// `ValueEvent` derives all tests from `value`: such an event is a few lines.
#pragma once

#include "kernels/intersection/surface.h"
#include "kernels/methods/task.h"

#include <cstdint>
#include <type_traits>

namespace kagero {

enum class Effect : std::uint8_t {
    end,     ///< the ray ends at the event
    split,   ///< the step ends at the event, and the next one starts there
    resume,  ///< the ray goes on from the event with another state
};

/// An event whose `value` is a function of the state alone.
template <class Event>
struct ValueEvent {
    static constexpr Effect effect = Effect::end;
    /// Whether another event may lie before this one on the same step.
    static constexpr bool may_follow_another = true;
    /// Whether the ray ends at the end of its whole step if the event cannot be refined.
    static constexpr bool certain = false;

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
        return Event::value(start, at) < V(-beyond_rounding<ScalarOf<V>>) * abs(Event::value(start, start));
    }

    /// The place of an event is not known better than to this share of its value at the start of the step.
    template <class S>
    static constexpr S beyond_rounding = std::is_same_v<S, float> ? S(1e-5) : S(1e-10);
};

template <class Event, class V>
concept HasValue = requires(const RayState<V>& at) {
    Event::value(at, at);
};
template <class Event, class V>
concept HasLevel = requires(const Task<V>& task) {
    Event::level(task);
};

}  // namespace kagero
