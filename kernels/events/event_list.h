/// Lists of events, and sets of lanes by event.
#pragma once

#include "kernels/events/event.h"

namespace kagero {

template <class... Event>
struct EventList {
    static constexpr int count = sizeof...(Event);
    /// The index of an event in the list.
    template <class E>
    static constexpr int index = [] {
        int i = 0, found = -1;
        ((std::is_same_v<E, Event> ? found = i++ : i++), ...);
        return found;
    }();
    /// Whether no event but the given ones exists.
    template <class... Known, class V>
    static bool exist_only(const Task<V>& task) {
        const auto is_known = []<class E>() { return (std::is_same_v<E, Known> || ...); };
        return ((is_known.template operator()<Event>() || !Event::exists(task)) && ...);
    }
    /// Calls f.operator()<Event>() for every event.
    template <class F>
    KAGERO_INLINE static void each(const F& f) {
        (f.template operator()<Event>(), ...);
    }
};

/// A set of lanes for every event.
template <class Events>
struct LanesOfEvents {
    std::uint64_t lanes[Events::count] = {};
    template <class Event>
    std::uint64_t& of() {
        return lanes[Events::template index<Event>];
    }
    template <class Event>
    std::uint64_t of() const {
        return lanes[Events::template index<Event>];
    }
    std::uint64_t all() const {
        std::uint64_t any = 0;
        for (const std::uint64_t of_event : lanes) any |= of_event;
        return any;
    }
};

}  // namespace kagero
