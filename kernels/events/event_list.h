/// The list of all events. One more event is one more file and one more row.
#pragma once

#include "kernels/events/capture.h"
#include "kernels/events/discontinuity.h"
#include "kernels/events/escape_sphere.h"
#include "kernels/events/limits.h"
#include "kernels/events/medium_edge.h"
#include "kernels/events/surface_hit.h"
#include "kernels/events/turning_point.h"

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
    KAGERO_INLINE static void each(const F& f) { (f.template operator()<Event>(), ...); }
};

/// In the order in which a step is tested for them; a lane takes the first event that it has crossed, until refinement finds an earlier one.
using Events = EventList<
    SurfaceHit,
    MediumEdge,
    TurningPoint,
    EscapeSphere,
    SecondEscapeSphere,
    Capture,
    ParameterLimit,
    StepLimit,
    Discontinuity>;

/// A set of lanes for every event.
struct LanesOfEvents {
    std::uint64_t lanes[Events::count] = {};
    template <class Event>
    std::uint64_t& of() { return lanes[Events::index<Event>]; }
    template <class Event>
    std::uint64_t of() const { return lanes[Events::index<Event>]; }
    std::uint64_t all() const {
        std::uint64_t any = 0;
        for (const std::uint64_t of_event : lanes) any |= of_event;
        return any;
    }
};

}  // namespace kagero
