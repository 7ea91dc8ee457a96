/// The tracing loop: advances a packet of rays in lockstep until all of them have ended.
///
/// The loop is compiled once per value type; scalars and packets of any width run these lines. The Hamiltonian and the
/// method are behind `SpaceKernel`. A step goes through `advance`: step, accept, split, detect, write, next. Events
/// within a step are set aside with their rays. They are refined together when the packet has no active ray left, or
/// before idle lanes get new rays (`refine_events`).
#pragma once

#include "kernels/events/event_detector.h"
#include "kernels/events/event_refiner.h"
#include "kernels/trace/escaping_rays.h"
#include "kernels/trace/ray_end_writer.h"
#include "kernels/trace/ray_loader.h"
#include "kernels/trace/step_control.h"
#include "kernels/trace/straight_rays.h"

#include <optional>

namespace kagero {

/// How rays get to their ends.
enum class Route { steps, closed_form, to_escape };

template <class Events, class V>
Route route_of(const Task<V>& task) {
    if (task.job.path_sink) return Route::steps;
    if (task.straight) {
        const bool straight_to_end =
            Events::template exist_only<SurfaceHit, TurningPoint, EscapeSphere, Capture, StepLimit, Discontinuity>(
                task);
        return straight_to_end ? Route::closed_form : Route::steps;
    }
    const bool meets_nothing = Events::template exist_only<MediumEdge, TurningPoint, EscapeSphere, SecondEscapeSphere,
                                                           Capture, StepLimit, Discontinuity>(task);
    return meets_nothing && task.can_integrate_to_escape() ? Route::to_escape : Route::steps;
}

/// The rays of one packet from start to end: `start`, then `step` as long as it `goes_on`, then `finish`.
template <class V, class Events = AllEvents>
class PacketTracer {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    PacketTracer(const Task<V>& task, Counters& counters)
        : task_(task), counters_(counters), route_(route_of<Events>(task)), writer_(task, packet_, counters),
          loader_(task, packet_, writer_), control_(task, packet_, writer_), detector_(task), discontinuity_(task) {
        writer_.set_scene(detector_.scene());
    }

    /// Loads a packet of rays from the queue. Rays with a short way to their end take it.
    void start(RayQueue<W>& queue) {
        load(queue, all_lanes<W>);
        if (!packet_.filled) return;
        if (route_ == Route::closed_form) end_straight();
        if (route_ == Route::to_escape && packet_.active) escape();
        if (packet_.active) refiner_.emplace(task_);
    }
    /// Whether some ray goes on. If no ray is active, the events that were set aside are refined; a ray whose event
    /// cannot be refined goes on.
    bool goes_on() {
        if (!packet_.active && refiner_) refine_events();
        return packet_.active != 0;
    }
    /// One step of all active rays. Idle lanes get new rays if the job wants that.
    void step(RayQueue<W>& queue) {
        // To load rays costs about as much as a step, so it is done for some lanes at a time.
        constexpr int few = W - (W + 3) / 4;
        advance();
        while (task_.job.refill && route_ == Route::steps && !queue.empty() &&
               __builtin_popcountll(packet_.active) <= few) {
            refine_events();
            writer_.write_occupancy(~packet_.active & packet_.filled);
            load(queue, ~packet_.active & all_lanes<W>);
        }
    }
    /// Counts a step that other packets take while all rays of this one have ended.
    void idle() { counters_.issued_lane_steps += W; }
    /// Writes the counters of the packet; call it after all rays have ended.
    void finish() {
        if (!packet_.filled) return;
        if (refiner_) writer_.write_occupancy(packet_.filled);
        if (const SceneIntersector<V>* scene = detector_.scene()) counters_.query_ticks += scene->ticks;
        counters_.issued_iterations += packet_.state.issued_iterations * W;
    }

private:
    void load(RayQueue<W>& queue, std::uint64_t free);
    void start_steps(std::uint64_t lanes);
    void end_straight();
    void escape();
    void advance();
    std::uint64_t split(std::uint64_t moving);
    void end_at_step_end(const Detected<Events>& found);
    void next(std::uint64_t moving, std::uint64_t staying);
    void refine_events();
    void refine_once(bool look_for_earlier);
    void end_refined(std::uint64_t lanes);
    void resume(std::uint64_t lanes);
    std::uint64_t undo(std::uint64_t lanes);

    const Task<V>& task_;
    Counters& counters_;
    const Route route_;
    Packet<V> packet_;
    RayEndWriter<V> writer_;
    RayLoader<V, Events> loader_;
    StepControl<V, Events> control_;
    EventDetector<V, Events> detector_;
    DiscontinuitySearch<V> discontinuity_;
    std::optional<EventRefiner<V, Events>> refiner_;  ///< exists where rays take steps
};

// --- The start of rays ------------------------------------------------------------------------------------------------

/// New rays in lanes that are free.
template <class V, class Events>
void PacketTracer<V, Events>::load(RayQueue<W>& queue, std::uint64_t free) {
    RayStarts<W> starts;
    const std::uint64_t lanes = queue.take(free, starts, packet_.ends, packet_.numbers);
    if (!lanes) return;
    if (packet_.filled) loader_.load_more(starts, lanes);
    else loader_.load_first(starts, lanes);
    control_.begin(lanes);
    detector_.begin(lanes);
    loader_.activate(starts, lanes);
    if (route_ != Route::closed_form) start_steps(lanes);
}

/// The first steps of the rays in `lanes`.
template <class V, class Events>
void PacketTracer<V, Events>::start_steps(std::uint64_t lanes) {
    control_.start_steps(lanes);
    detector_.start_steps(packet_.state.start, lanes);
}

template <class V, class Events>
void PacketTracer<V, Events>::end_straight() {
    end_straight_rays(task_, packet_, detector_.scene(), writer_, counters_);
    if (packet_.active) start_steps(packet_.filled);
}

template <class V, class Events>
void PacketTracer<V, Events>::escape() {
    std::uint64_t moving;
    const std::uint64_t escaped = integrate_to_escape(task_, packet_, writer_, counters_, moving);
    if (packet_.active == escaped) packet_.active = 0;
    else next(moving, moving & ~escaped);
    detector_.start_steps(packet_.state.start, moving);
}

// --- A step -----------------------------------------------------------------------------------------------------------

template <class V, class Events>
void PacketTracer<V, Events>::advance() {
    StepperState<V>& state = packet_.state;
    KAGERO_ASSERT(packet_.active && (packet_.active & ~packet_.filled) == 0);
    counters_.issued_lane_steps += W;
    counters_.active_lane_steps += static_cast<std::uint64_t>(__builtin_popcountll(packet_.active));

    task_.step(state);                                           // step
    std::uint64_t moving = control_.accept();                    // a rejected step is taken again
    if (Discontinuity::exists(task_)) moving &= ~split(moving);  // and so is one that has to end earlier

    const V steps = packet_.steps + V(S(1));                     // detect
    const Detected<Events> found = detector_.detect(state, moving, steps, refiner_->deferred);
    if (found.too_bent) {
        control_.repeat(found.too_bent, V(S(0.5)) * state.h);
        moving &= ~found.too_bent;
    }
    packet_.count_step(moving);

    const std::uint64_t staying = moving & ~found.stopped();     // write
    if (found.at_end) end_at_step_end(found);
    if (task_.job.path_sink) writer_.report_path(state, staying, false);

    next(moving, staying);                                       // next
}

/// Lanes whose step crosses a discontinuity take it again, to end there; returns them.
template <class V, class Events>
std::uint64_t PacketTracer<V, Events>::split(std::uint64_t moving) {
    const SplitSteps<V> shorter = discontinuity_.split(packet_.state, moving, control_.first_tries());
    control_.repeat(shorter.lanes, shorter.length);
    return shorter.lanes;
}

/// Rays whose event lies at the end of their step end there.
template <class V, class Events>
void PacketTracer<V, Events>::end_at_step_end(const Detected<Events>& found) {
    Events::each([&]<class Event>() {
        if constexpr (Event::effect == Effect::end) {
            const std::uint64_t lanes = found.at_end & found.lanes_of.template of<Event>();
            if (!lanes) return;
            if constexpr (requires { Event::finish(task_, packet_.state, lanes); })
                Event::finish(task_, packet_.state, lanes);
            writer_.end_rays(packet_.state, lanes, Event::status);
        }
    });
}

/// The end of the step of `moving` becomes the start of the next one for the lanes of `staying`; the others become
/// inactive.
template <class V, class Events>
void PacketTracer<V, Events>::next(std::uint64_t moving, std::uint64_t staying) {
    StepperState<V>& state = packet_.state;
    KAGERO_ASSERT((staying & ~moving) == 0 && (moving & ~packet_.active) == 0);
    if (staying == all_lanes<W>) {
        task_.begin_next(state);
        state.h = control_.next_length();
        control_.forget(staying);
        return;
    }
    if (const std::uint64_t leaving = moving & ~staying) {
        const MaskOf<V> gone = from_bits<V>(leaving);
        packet_.active &= ~leaving;
        packet_.iterations_at_end = select(gone, state.open_iterations, packet_.iterations_at_end);
        packet_.step_length = select(gone, V(S(0)), packet_.step_length);
    }
    const MaskOf<V> going = from_bits<V>(staying), inactive = from_bits<V>(~packet_.active);
    task_.begin_next(state, going);
    state.h = select(going | inactive, control_.next_length(), state.h);
    control_.forget(staying);
}

// --- The refinement of events -----------------------------------------------------------------------------------------

/// Refines the events that were set aside. A step may have several events; the earliest is found one refinement after
/// the other.
template <class V, class Events>
void PacketTracer<V, Events>::refine_events() {
    constexpr int max_refinements = 4;
    const Stopwatch watch(task_.job.timed && refiner_->deferred.lanes, counters_.landing_ticks);
    for (int i = 1; i <= max_refinements && refiner_->deferred.lanes; ++i) refine_once(i < max_refinements);
}

/// Refines the events that were set aside, once. Rays that have crossed another event before are set aside again, for
/// that one.
template <class V, class Events>
void PacketTracer<V, Events>::refine_once(bool look_for_earlier) {
    EventRefiner<V, Events>& refiner = *refiner_;
    DeferredEvents<V, Events>& deferred = refiner.deferred;
    refiner.refine();
    const LanesOfEvents<Events> earlier = look_for_earlier ? refiner.earlier_events() : LanesOfEvents<Events>{};
    const std::uint64_t again = earlier.all(), lost = deferred.lanes & refiner.unreached,
                        undone = lost ? undo(lost) : 0;
    const std::uint64_t resumed = deferred.lanes & ~(lost | again) & deferred.template lanes_with<Effect::resume>();
    const std::uint64_t ended = deferred.lanes & ~(undone | again | resumed);
    if (packet_.state.options.want_energy)
        packet_.worst_energy =
            select(from_bits<V>(ended), max(packet_.worst_energy, deferred.step.energy_error), packet_.worst_energy);
    writer_.end_rays(deferred.step, lost & ~undone, Status::failed, Failure::not_landed);
    end_refined(ended & ~lost);
    writer_.write_iterations(ended, packet_.iterations_at_end);
    writer_.write_unrefined(ended & ~lost & refiner.unrefined);
    if (resumed) resume(resumed);
    refiner.defer_again(earlier);
}

/// Writes the ends of refined rays, by their status.
template <class V, class Events>
void PacketTracer<V, Events>::end_refined(std::uint64_t lanes) {
    const DeferredEvents<V, Events>& deferred = refiner_->deferred;
    std::uint64_t by_status[status_count] = {};
    Events::each([&]<class Event>() {
        if constexpr (Event::effect == Effect::end)
            by_status[static_cast<int>(Event::status)] |= lanes & deferred.lanes_of.template of<Event>();
    });
    writer_.set_surfaces(deferred.surface, deferred.primitive);
    for (std::uint32_t s = 0; s < status_count; ++s)
        writer_.end_rays(deferred.step, by_status[s], static_cast<Status>(s));
}

/// Rays go on from their refined event, each with the state that the event gives it.
template <class V, class Events>
void PacketTracer<V, Events>::resume(std::uint64_t lanes) {
    DeferredEvents<V, Events>& deferred = refiner_->deferred;
    if (task_.job.path_sink) writer_.report_path(deferred.step, lanes, false);
    RayState<V> at = deferred.step.end;
    Events::each([&]<class Event>() {
        if constexpr (Event::effect == Effect::resume) {
            if (const std::uint64_t of_event = lanes & deferred.lanes_of.template of<Event>()) {
                RayState<V> changed = at;
                Event::resume(task_, changed);
                RayState<V>::each(at, changed, CopyLanes<V>{from_bits<V>(of_event)});
            }
        }
    });
    loader_.resume(at, deferred.step, lanes);
    detector_.return_to_start(lanes);
    start_steps(lanes);
}

/// Events of `lanes` could not be refined: their steps were too long, and are taken again; returns the lanes that go
/// on.
template <class V, class Events>
std::uint64_t PacketTracer<V, Events>::undo(std::uint64_t lanes) {
    const std::uint64_t again = control_.undo(refiner_->whole, lanes);
    detector_.start_steps(packet_.state.start, again);
    detector_.return_to_start(again & to_bits(packet_.steps <= V(S(0))));
    return again;
}

}  // namespace kagero
