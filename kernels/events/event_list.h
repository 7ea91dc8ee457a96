/// A compile-time list of event types, and one lane mask for each event of a list.
#pragma once

#include "kernels/events/event.h"

namespace kagero {

/// A list of event types.
template <class... Event>
struct EventList {
    static constexpr int count = sizeof...(Event);
    /// Index of an event in the list; −1 if it is not in the list.
    template <class Wanted>
    static constexpr int index = [] {
        int i = 0, found = -1;
        ((std::is_same_v<Wanted, Event> ? found = i++ : i++), ...);
        return found;
    }();
    /// Returns true if all events that exist for the task are among `Known`.
    template <class... Known, class V>
    static bool exist_only(const Task<V>& task) {
        const auto is_known = []<class Wanted>() { return (std::is_same_v<Wanted, Known> || ...); };
        return ((is_known.template operator()<Event>() || !Event::exists(task)) && ...);
    }
    /// Calls f.operator()<Event>() for every event, in the order of the list.
    template <class F>
    KAGERO_INLINE static void each(const F& f) {
        (f.template operator()<Event>(), ...);
    }
};

/// One lane mask for each event of a list.
template <class Events>
struct LanesOfEvents {
    std::uint64_t lanes[Events::count] = {};  ///< In the order of the list.
    /// Returns the lanes of one event.
    template <class Event>
    std::uint64_t& of() {
        return lanes[Events::template index<Event>];
    }
    template <class Event>
    std::uint64_t of() const {
        return lanes[Events::template index<Event>];
    }
    /// Returns the lanes that have at least one event.
    std::uint64_t lanes_with_event() const {
        std::uint64_t with_event = 0;
        for (const std::uint64_t of_event : lanes) with_event |= of_event;
        return with_event;
    }
};

}  // namespace kagero
