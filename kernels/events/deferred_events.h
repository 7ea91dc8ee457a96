/// The detected events of a packet that have not been refined yet.
///
/// Refinement takes several steps of the packet, whether one lane has an event or all lanes have one. An event is
/// therefore stored with its step until the packet has no active ray or is refilled. Then all events of the packet are
/// refined together.
#pragma once

#include "kernels/events/all_events.h"
#include "kernels/intersection/passed_primitives.h"

namespace kagero {

/// The deferred events of one packet, at most one for each lane.
template <class V, class Events = AllEvents>
struct DeferredEvents {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

    StepperState<V> step;            ///< Steps of the lanes with an event; other lanes hold an arbitrary finite step.
    Curve<V> curve;                  ///< Dense output of `step`; `refine` sets it if it is the cubic Hermite curve.
    std::uint64_t lanes = 0;         ///< Lanes with an event.
    LanesOfEvents<Events> lanes_of;  ///< The lanes of `lanes` by type of event.
    LevelSet<V> level_set = LevelSet<V>::none();  ///< Level set of each event; none() for an event with a `value`.
    V lo = S(0), hi = S(0);                  ///< Bounds of the event's position, as fractions of the step.
    V event_fraction = S(0);                 ///< Fraction of the step at the event: estimated, then refined.
    std::uint32_t surface[W], primitive[W];  ///< Surfaces and primitives that lanes with a SurfaceHit have hit.
    PassedPrimitives<W> passed;  ///< Primitives that the ray passes on the outside; their hits were not confirmed.
    /// Lanes whose ray starts on the sphere that it hits, and inside, although its start may lie outside by rounding.
    std::uint64_t inside = 0;
    std::uint64_t departing = 0;  ///< Lanes whose hit is on the first piece of a ray that starts on a named surface.
    std::uint32_t start_surface[W], start_primitive[W];  ///< The named surfaces of the lanes of `departing`.

    /// Returns the lanes whose event has this effect.
    template <Effect effect>
    std::uint64_t lanes_with() const {
        std::uint64_t with_effect = 0;
        Events::each([&]<class Event>() {
            if constexpr (Event::effect == effect) with_effect |= lanes_of.template of<Event>();
        });
        return with_effect;
    }
    /// Removes all events.
    void clear() {
        lanes = 0;
        lanes_of = {};
        level_set.curved = false;
    }

    /// Adds the event of the lanes `added`: the point on the level set `target` between the fractions `from` and `to`
    /// of the step. `estimate` is the estimated fraction.
    template <class Event>
    void defer(std::uint64_t added, const LevelSet<V>& target, const V& from, const V& to, const V& estimate) {
        lanes_of.template of<Event>() |= added;
        add(added, target, from, to, estimate);
    }
    /// Adds the event of the lanes `added`, which lies between the start of the step and the state `beyond` at
    /// `fraction` of the step. The event's position is estimated by linear interpolation.
    template <class Event>
    void defer_before(const Task<V>& task, std::uint64_t added, const RayState<V>& start, const RayState<V>& beyond,
                      const V& fraction) {
        lanes_of.template of<Event>() |= added;
        if constexpr (HasLevelSet<Event, V>) {
            const LevelSet<V> target = Event::level_set(task);
            add(added, target, V(S(0)), fraction, fraction * chord_fraction(target, start.q(), beyond.q(), V(S(1))));
        } else {
            const V before = Event::value(start, start), after = Event::value(start, beyond);
            add(added, LevelSet<V>::none(), V(S(0)), fraction, fraction * before / (before - after));
        }
    }
    /// Stores the steps of the lanes `added`, and their dense output if the method defines one.
    void store_steps(const Task<V>& task, const StepperState<V>& from, std::uint64_t added) {
        Step<V>& stored = step;
        if (lanes == added) stored = from;  // `added` are the only deferred lanes; other lanes get a finite step
        else stored.copy_lanes(from, from_bits<V>(added));
        stored.ingoing = (stored.ingoing & ~added) | (from.ingoing & added);
        if (!task.method_curve) return;
        const Curve<V> dense_output = task.curve(from);
        curve.degree = dense_output.degree;
        for (int i = 0; i <= dense_output.degree; ++i)
            curve.point[i] = select<V>(from_bits<V>(added), dense_output.point[i], curve.point[i]);
    }

private:
    void add(std::uint64_t added, const LevelSet<V>& target, const V& from, const V& to, const V& estimate) {
        const MaskOf<V> mask = from_bits<V>(added);
        level_set.assign_lanes(mask, target);
        lo = select(mask, from, lo);
        hi = select(mask, to, hi);
        event_fraction = select(mask, estimate, event_fraction);
        lanes |= added;
    }
};

}  // namespace kagero
