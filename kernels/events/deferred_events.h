/// The events that a packet has met and not yet refined.
///
/// Refinement costs several steps. A ray that has met an event is set aside with its step until the rest of its packet
/// has ended, and all events of the packet are refined together.
#pragma once

#include "kernels/events/all_events.h"

namespace kagero {

template <class V, class Events = AllEvents>
struct DeferredEvents {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

    StepperState<V> step;               ///< the steps of deferred lanes; other lanes hold a finite step of no meaning
    Curve<V> curve;                     ///< their dense output, if the method has its own; else the refiner makes it
    std::uint64_t lanes = 0;            ///< lanes with an event
    LanesOfEvents<Events> lanes_of;     ///< the same by event
    Level<V> level = Level<V>::none();  ///< of events that have one
    V lo = S(0), hi = S(0);             ///< the event lies within these fractions of the step
    V guess = S(0);                     ///< probably here; after refinement, exactly here
    std::uint32_t surface[W], primitive[W];  ///< what lanes with a SurfaceHit hit

    /// The lanes whose event has this effect.
    template <Effect effect>
    std::uint64_t lanes_with() const {
        std::uint64_t all = 0;
        Events::each([&]<class Event>() {
            if constexpr (Event::effect == effect) all |= lanes_of.template of<Event>();
        });
        return all;
    }
    void clear() { lanes = 0, lanes_of = {}, level.curved = false; }

    /// Adds an event that has a level, within [lo, hi] of the step.
    template <class Event>
    void defer(std::uint64_t added, const Level<V>& at, const V& from, const V& to, const V& probably) {
        lanes_of.template of<Event>() |= added;
        set(added, at, from, to, probably);
    }
    /// Adds an event between the start of the step and the state `beyond` it, at a fraction of the step.
    template <class Event>
    void defer_before(const Task<V>& task, std::uint64_t added, const RayState<V>& start, const RayState<V>& beyond,
                      const V& fraction) {
        lanes_of.template of<Event>() |= added;
        if constexpr (HasLevel<Event, V>) {
            const Level<V> at = Event::level(task);
            set(added, at, V(S(0)), fraction, fraction * chord_fraction(at, start.q(), beyond.q(), V(S(1))));
        } else {
            const V before = Event::value(start, start), after = Event::value(start, beyond);
            set(added, Level<V>::none(), V(S(0)), fraction, fraction * before / (before - after));
        }
    }
    /// Stores the steps of lanes that were added.
    void take(const Task<V>& task, const StepperState<V>& from, std::uint64_t added) {
        Step<V>& stored = step;
        if (lanes == added) stored = from;  // every other lane of it is harmless
        else stored.take(from, from_bits<V>(added));
        if (!task.own_curve) return;
        const Curve<V> own = task.curve(from);
        curve.degree = own.degree;
        for (int i = 0; i <= own.degree; ++i)
            curve.point[i] = select<V>(from_bits<V>(added), own.point[i], curve.point[i]);
    }

private:
    void set(std::uint64_t added, const Level<V>& at, const V& from, const V& to, const V& probably) {
        const MaskOf<V> here = from_bits<V>(added);
        level.take(here, at);
        lo = select(here, from, lo), hi = select(here, to, hi), guess = select(here, probably, guess);
        lanes |= added;
    }
};

}  // namespace kagero
