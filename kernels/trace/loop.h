/// The tracing loop: advances a packet of rays in lockstep until all of them have ended.
///
/// The loop is compiled once per value type; scalars and packets of any width use the same code. The Hamiltonian and
/// the method are called through `SpaceKernel`. The function `advance` performs one step: step, accept, split, detect,
/// write, next. The refinement of events within a step is deferred. Deferred events are refined together when the
/// packet has no active ray left, or before idle lanes get new rays (`refine_events`).
#pragma once

#include "kernels/events/event_detector.h"
#include "kernels/events/event_refiner.h"
#include "kernels/events/kinks.h"
#include "kernels/trace/chart_correction.h"
#include "kernels/trace/escaping_rays.h"
#include "kernels/trace/path_recorder.h"
#include "kernels/trace/ray_end_writer.h"
#include "kernels/trace/ray_loader.h"
#include "kernels/trace/step_control.h"
#include "kernels/trace/straight_rays.h"
#include "kernels/trace/trace_algorithm.h"

#include <optional>

namespace kagero {

/// Traces the rays of one packet. The caller calls `start`, then `step` while `prepare_step` returns true, then
/// `finish`.
template <class V, class Events = AllEvents>
class PacketTracer {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    PacketTracer(const Task<V>& task, Counters& counters)
        : task_(task), counters_(counters), algorithm_(trace_algorithm_of<Events>(task)),
          writer_(task, packet_, counters), loader_(task, packet_, writer_), control_(task, packet_, writer_),
          detector_(task), discontinuity_(task), kinks_(task), recorder_(task, packet_, writer_) {
        writer_.set_scene(detector_.scene());
    }

    /// Loads a packet of rays from the queue. Ends the rays whose ends can be computed without the loop.
    void start(RayQueue<W>& queue) {
        load(queue, all_lane_bits<W>);
        if (!packet_.filled) return;
        if (algorithm_ == TraceAlgorithm::closed_form) end_straight();
        if (algorithm_ == TraceAlgorithm::to_escape && packet_.active) escape();
        if (packet_.active) refiner_.emplace(task_);
    }
    /// Refines the deferred events if no ray is active. Returns true if the packet has an active ray: a ray becomes
    /// active again if its event cannot be refined, or if the event lets it continue.
    bool prepare_step() {
        if (!packet_.active && refiner_) refine_events();
        return packet_.active != 0;
    }
    /// Advances all active rays by one step. Loads new rays into idle lanes if Job::refill is set.
    void step(RayQueue<W>& queue) {
        // Loading rays costs about as much as a step, so it is done for at least a quarter of the lanes at a time.
        constexpr int refill_limit = W - (W + 3) / 4;
        advance();
        while (task_.job.refill && algorithm_ == TraceAlgorithm::steps && !queue.empty() &&
               __builtin_popcountll(packet_.active) <= refill_limit) {
            refine_events();
            writer_.write_occupancy(~packet_.active & packet_.filled);
            load(queue, ~packet_.active & all_lane_bits<W>);
        }
    }
    /// Counts the lanes of this packet as idle. Called when the packet has no active ray, but others of its gang do.
    void idle() { counters_.issued_lane_steps += W; }
    /// Writes the occupancy of each ray, and adds query ticks and issued iterations of this packet to the counters.
    /// Must be called after all rays have ended.
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
    std::uint64_t pass_kinks();
    void end_at_step_end(const Detected<Events>& found);
    void next(std::uint64_t moving, std::uint64_t continuing);
    void refine_events();
    void refine_once(bool find_earlier);
    void end_refined(std::uint64_t lanes);
    void resume(std::uint64_t lanes);
    std::uint64_t repeat_halved(std::uint64_t lanes);

    const Task<V>& task_;
    Counters& counters_;
    const TraceAlgorithm algorithm_;
    Packet<V> packet_;
    RayEndWriter<V> writer_;
    RayLoader<V, Events> loader_;
    StepControl<V, Events> control_;
    EventDetector<V, Events> detector_;
    DiscontinuitySearch<V> discontinuity_;
    KinkSearch<V> kinks_;
    std::optional<EventRefiner<V, Events>> refiner_;  ///< Exists only if a ray of the packet takes steps.
    PathRecorder<V> recorder_;
};

// --- Start of rays ---

/// Loads new rays from the queue into the lanes `free`.
template <class V, class Events>
void PacketTracer<V, Events>::load(RayQueue<W>& queue, std::uint64_t free) {
    RayStarts<W> starts;
    const std::uint64_t lanes = queue.next_rays(free, starts, packet_.ends, packet_.ray_indices);
    if (!lanes) return;
    if (packet_.filled) loader_.load_more(starts, lanes);
    else loader_.load_first(starts, lanes);
    control_.begin(lanes);
    detector_.begin(lanes, starts.on_surface, starts.surface, starts.primitive);
    if (recorder_.records) recorder_.begin(lanes);
    loader_.activate(starts, lanes);
    if (algorithm_ != TraceAlgorithm::closed_form) start_steps(lanes);
    if (ChartSphere::exists(task_)) start_steps(correct_charts(task_, packet_, loader_, recorder_, lanes));
}

/// Prepares the first steps of the rays in `lanes`: sets their lengths, and records which rays move outward.
template <class V, class Events>
void PacketTracer<V, Events>::start_steps(std::uint64_t lanes) {
    if (!lanes) return;
    control_.start_steps(lanes);
    detector_.start_steps(packet_.state.start, lanes);
}

/// Ends the straight rays of the packet in closed form.
template <class V, class Events>
void PacketTracer<V, Events>::end_straight() {
    end_straight_rays(task_, packet_, detector_.scene(), writer_, recorder_.integrals, counters_);
    if (packet_.active) start_steps(packet_.filled);
}

/// Integrates the rays of the packet to the escape sphere without the loop.
template <class V, class Events>
void PacketTracer<V, Events>::escape() {
    std::uint64_t moving;
    const std::uint64_t ended = integrate_to_escape(task_, packet_, writer_, counters_, moving);
    if (packet_.active == ended) packet_.active = 0;
    else next(moving, moving & ~ended);
    detector_.start_steps(packet_.state.start, moving);
    if (ChartSphere::exists(task_)) start_steps(correct_charts(task_, packet_, loader_, recorder_, packet_.active));
}

// --- Steps ---

/// Performs one step of all active rays.
template <class V, class Events>
void PacketTracer<V, Events>::advance() {
    StepperState<V>& state = packet_.state;
    KAGERO_ASSERT(packet_.active && (packet_.active & ~packet_.filled) == 0);
    counters_.issued_lane_steps += W;
    counters_.active_lane_steps += static_cast<std::uint64_t>(__builtin_popcountll(packet_.active));

    task_.step(state);                                                      // step
    const std::uint64_t repeated = task_.kernel.kinked ? pass_kinks() : 0;  // split: steps end before kinks
    std::uint64_t moving = control_.accept(repeated);                       // accept: rejected steps are repeated
    if (Discontinuity::exists(task_)) moving &= ~split(moving);             // split: steps end on discontinuities

    const V steps = packet_.steps + V(S(1));                     // detect
    const Detected<Events> found = detector_.detect(state, moving, steps, refiner_->deferred);
    if (found.too_curved) {
        control_.repeat(found.too_curved, V(S(0.5)) * state.h);
        moving &= ~found.too_curved;
    }
    packet_.count_step(moving);
    if (recorder_.records) recorder_.add_step(moving & ~found.within);

    const std::uint64_t continuing = moving & ~found.stopped();  // write
    if (found.at_end) end_at_step_end(found);
    if (task_.job.path_sink) writer_.report_path(state, continuing, false);

    next(moving, continuing);                                    // next
    if (ChartSphere::exists(task_)) start_steps(correct_charts(task_, packet_, loader_, recorder_, continuing));
}

/// Schedules the repetition of steps that cross a discontinuity, so that they end on it. Returns their lanes.
template <class V, class Events>
std::uint64_t PacketTracer<V, Events>::split(std::uint64_t moving) {
    const SplitSteps<V> shorter = discontinuity_.split(packet_.state, moving, control_.first_tries());
    control_.repeat(shorter.lanes, shorter.length);
    return shorter.lanes;
}

/// Schedules the repetition of steps that cross a kink, so that they end before it, and keeps the step lengths of rays
/// that pass a kink in one short step. Ends the rays whose H jumps there. Returns the lanes whose step is not accepted.
template <class V, class Events>
std::uint64_t PacketTracer<V, Events>::pass_kinks() {
    const KinkSteps<V> kinks = kinks_.find(packet_.state, packet_.active);
    control_.repeat(kinks.shortened, kinks.length);
    const std::uint64_t failed = kinks.shortened & ~packet_.active,
                        jumping = kinks_.jumping(packet_.state, kinks.passing);
    if (jumping) writer_.fail_at_step_start(jumping, Failure::hamiltonian_jumps);
    control_.keep_length(kinks.passing & ~jumping);
    return kinks.shortened | failed | jumping;
}

/// Ends the rays whose event takes place at the end of their step.
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

/// Begins the next step in the lanes `continuing`, at the end of their last step. Deactivates the other lanes of
/// `moving`.
template <class V, class Events>
void PacketTracer<V, Events>::next(std::uint64_t moving, std::uint64_t continuing) {
    StepperState<V>& state = packet_.state;
    KAGERO_ASSERT((continuing & ~moving) == 0 && (moving & ~packet_.active) == 0);
    if (continuing == all_lane_bits<W>) {
        task_.begin_next(state);
        state.h = control_.next_length();
        control_.reset_repetitions(continuing);
        return;
    }
    if (const std::uint64_t leaving = moving & ~continuing) {
        const MaskOf<V> mask = from_bits<V>(leaving);
        packet_.active &= ~leaving;
        packet_.iterations_of_ray = select(mask, state.lane_iterations, packet_.iterations_of_ray);
        packet_.step_length = select(mask, V(S(0)), packet_.step_length);
    }
    const MaskOf<V> continuing_mask = from_bits<V>(continuing), inactive = from_bits<V>(~packet_.active);
    task_.begin_next(state, continuing_mask);
    state.h = select(continuing_mask | inactive, control_.next_length(), state.h);
    control_.reset_repetitions(continuing);
}

// --- Refinement of events ---

/// Refines the deferred events. A step may have several events. The refinement is therefore repeated, at most three
/// times, until no earlier event is found.
template <class V, class Events>
void PacketTracer<V, Events>::refine_events() {
    constexpr int max_refinements = 4;
    const Stopwatch watch(task_.job.timed && refiner_->deferred.lanes, counters_.refinement_ticks);
    for (int i = 1; i <= max_refinements && refiner_->deferred.lanes; ++i) refine_once(i < max_refinements);
}

/// Refines the deferred events once. If `find_earlier` is true, rays that have crossed another event before their
/// refined event are deferred again with that other event.
template <class V, class Events>
void PacketTracer<V, Events>::refine_once(bool find_earlier) {
    EventRefiner<V, Events>& refiner = *refiner_;
    DeferredEvents<V, Events>& deferred = refiner.deferred;
    refiner.refine();
    const LanesOfEvents<Events> earlier = find_earlier ? refiner.earlier_events() : LanesOfEvents<Events>{};
    const std::uint64_t with_earlier = earlier.lanes_with_event(), failed = deferred.lanes & refiner.failed,
                        repeated = failed ? repeat_halved(failed) : 0;
    const std::uint64_t refined = deferred.lanes & ~(failed | with_earlier),
                        resumed = refined & (deferred.template lanes_with<Effect::resume>() | refiner.missed);
    const std::uint64_t ended = deferred.lanes & ~(repeated | with_earlier | resumed);
    if (packet_.state.options.compute_energy_error)
        packet_.record_energy_error(deferred.step.energy_error, from_bits<V>(ended));
    if (recorder_.records) recorder_.add_part(refiner.whole_step, deferred, refined);
    writer_.end_rays(deferred.step, failed & ~repeated, Status::failed, Failure::not_refined);
    end_refined(ended & ~failed);
    writer_.write_iterations(ended, packet_.iterations_of_ray);
    writer_.write_unrefined(ended & ~failed & refiner.unrefined);
    if (resumed) resume(resumed);
    detector_.ignore_passed(resumed & refiner.missed, deferred);
    refiner.defer_again(earlier);
}

/// Writes the ends of the refined rays in `lanes`, with the status of their events.
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

/// Continues the rays of `lanes` from their refined event, with the state that the event defines.
template <class V, class Events>
void PacketTracer<V, Events>::resume(std::uint64_t lanes) {
    DeferredEvents<V, Events>& deferred = refiner_->deferred;
    if (task_.job.path_sink) writer_.report_path(deferred.step, lanes, false);
    RayState<V> state_at_event = deferred.step.end;
    Events::each([&]<class Event>() {
        if constexpr (Event::effect == Effect::resume) {
            if (const std::uint64_t of_event = lanes & deferred.lanes_of.template of<Event>()) {
                if constexpr (requires { Event::changes_chart; }) {
                    recorder_.change_chart(state_at_event, of_event, true, true);
                    packet_.state.ingoing &= ~of_event;
                }
                Event::resume(task_, state_at_event, of_event);
            }
        }
    });
    loader_.resume(state_at_event, deferred.step, lanes);
    detector_.leave_start(lanes);
    detector_.ignore_surface_at_start(lanes & ~refiner_->missed);
    start_steps(lanes);
}

/// Repeats the steps of `lanes`, whose events could not be refined, with half their length. Returns the lanes whose
/// rays continue; the steps of the other rays have been halved too often.
template <class V, class Events>
std::uint64_t PacketTracer<V, Events>::repeat_halved(std::uint64_t lanes) {
    const std::uint64_t repeated = control_.repeat_halved(refiner_->whole_step, lanes);
    detector_.start_steps(packet_.state.start, repeated);
    detector_.ignore_surface_at_start(repeated & to_bits(packet_.steps <= V(S(0))));
    return repeated;
}

}  // namespace kagero
