/// Decides whether steps stand, and takes rejected ones again with another length.
#pragma once

#include "kernels/events/all_events.h"
#include "kernels/trace/ray_end_writer.h"
#include "kernels/trace/step_length.h"

namespace kagero {

template <class V, class Events = AllEvents>
class StepControl {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    StepControl(const Task<V>& task, Packet<V>& packet, RayEndWriter<V>& writer)
        : task_(task), packet_(packet), writer_(writer), length_(task) {}

    /// New rays in `lanes`: nothing is known of their steps.
    void begin(std::uint64_t lanes) {
        repeated_ &= ~lanes, rejected_ &= ~lanes;
        for (const int i : lanes_in(lanes)) halvings_[i] = rejections_[i] = 0, halvings_of_ray_[i] = 0;
    }
    /// The first steps of the rays in `lanes`.
    void start_steps(std::uint64_t lanes) {
        const MaskOf<V> here = from_bits<V>(lanes);
        V& proposed = packet_.step_length;
        proposed = select(here, select(from_bits<V>(packet_.active), V(S(task_.job.step)), V(S(0))), proposed);
        packet_.state.h = select(here, next_length(), packet_.state.h);
    }
    /// The lengths of the next steps.
    V next_length() const { return length_(packet_.state.start, packet_.step_length); }

    /// The lanes whose step stands. A step without a solution, with numbers that are not finite, or that loses H, is
    /// rejected and halved; a method with step control rejects steps whose error is too large and proposes another
    /// length.
    std::uint64_t accept() {
        const StepperState<V>& step = packet_.state;
        const std::uint64_t finite = to_bits(is_finite(sum_of_all(step.end, step.end.velocity))),
                            solved = to_bits(step.solved);
        const bool adaptive = task_.method.info.adaptive && !task_.straight;
        const std::uint64_t accepted = adaptive ? to_bits(step.accepted) : packet_.active;
        KAGERO_ASSERT((accepted & ~all_lanes<W>) == 0);
        // Beyond the edge of the medium H has no meaning.
        const std::uint64_t lossy =
            step.options.test_energy ? accepted & ~to_bits(step.energy_holds | (step.end.domain <= V(S(0)))) : 0;
        std::uint64_t moving = packet_.active & finite & solved & ~lossy;
        if (moving != packet_.active)
            halve(packet_.active & ~moving, packet_.active & ~solved, lossy & finite & solved);
        if (adaptive) {
            repeat(moving & ~accepted, step.suggested);
            moving &= accepted;
            packet_.step_length = select(from_bits<V>(moving), step.suggested, packet_.step_length);
        }
        return moving;
    }
    /// Steps that are rejected are taken again with another length; after too many rejections in a row the ray fails.
    void repeat(std::uint64_t lanes, const V& length) {
        if (!lanes) return;
        repeated_ |= lanes, rejected_ |= lanes;
        std::uint64_t failed = 0;
        for (const int i : lanes_in(lanes))
            if (++rejections_[i] >= max_rejections) failed |= std::uint64_t(1) << i;
        restart(lanes, length);
        if (failed) writer_.fail_rays(failed, failed, 0);
    }
    /// The lanes whose step is the first one from its start.
    std::uint64_t first_tries() const { return ~rejected_; }
    /// The steps of `lanes` stand: their repetitions do not count for the next ones.
    KAGERO_INLINE void forget(std::uint64_t lanes) {
        for (const int i : lanes_in(lanes & repeated_)) halvings_[i] = rejections_[i] = 0;
        repeated_ &= ~lanes, rejected_ &= ~lanes;
    }

    /// An event could not be refined on the whole steps of `lanes`. Rays whose steps have not been halved too often go
    /// back to the start of the step, to take half of it; returns their lanes.
    std::uint64_t undo(const Step<V>& whole, std::uint64_t lanes) {
        constexpr std::uint16_t worth = 16;  // a halving in `halve` costs a step, here it costs a refinement
        std::uint64_t again = 0;
        for (const int i : lanes_in(lanes)) {
            halvings_of_ray_[i] = static_cast<std::uint16_t>(halvings_of_ray_[i] + worth);
            if (halvings_[i]++ < max_halvings && halvings_of_ray_[i] < max_halvings_of_ray)
                again |= std::uint64_t(1) << i;
        }
        if (!again) return 0;
        const MaskOf<V> here = from_bits<V>(again);
        Packet<V>& packet = packet_;
        packet.state.take(whole, here);
        packet.step_length =
            select(here, task_.method.info.adaptive ? whole.h : V(S(task_.job.step)), packet.step_length);
        packet.steps = select(here, packet.steps - V(S(1)), packet.steps);
        packet.state.open_iterations = select(here, packet.iterations_at_end, packet.state.open_iterations);
        packet.active |= again, repeated_ |= again;
        restart(again, whole.h * V(S(0.5)));
        return again;
    }

private:
    /// Lanes go back to the start of their step, and so does what the stepper remembers.
    void restart(std::uint64_t lanes, const V& length) {
        const MaskOf<V> mask = from_bits<V>(lanes);
        StepperState<V>& state = packet_.state;
        state.h = select(mask, length, state.h);
        if (task_.resumes) return;
        StepperState<V> again = state;
        task_.begin(again);
        take_stages(state, again, mask);
    }
    /// Lanes take half of their step; after too many halvings the ray ends at the edge of space where it is, or fails.
    void halve(std::uint64_t lanes, std::uint64_t unsolved, std::uint64_t lossy) {
        repeated_ |= lanes;
        std::uint64_t failed = 0;
        for (const int i : lanes_in(lanes))
            if (halvings_[i]++ >= max_halvings || halvings_of_ray_[i]++ >= max_halvings_of_ray)
                failed |= std::uint64_t(1) << i;
        if (failed) lanes &= ~end_at_edge(failed);
        restart(lanes, packet_.state.h * V(S(0.5)));
        if (failed &= lanes) writer_.fail_rays(failed, unsolved, lossy);
    }
    /// Ends those of `lanes` whose steps, halved many times, would lead along their tangent beyond an event: where H is
    /// not a number beyond it, no step can end there, and the ray is at the event but for the rest of a step. Returns
    /// the lanes that have ended.
    std::uint64_t end_at_edge(std::uint64_t lanes) {
        if (task_.method.info.angular) return 0;
        StepperState<V> ahead = packet_.state, last = packet_.state;
        ahead.start.set(advance(ahead.start.q(), ahead.h, ahead.start.velocity), ahead.start.p());
        task_.begin(ahead);
        last.end = last.start;
        std::uint64_t ended = 0;
        Events::each([&]<class Event>() {
            if constexpr (HasValue<Event, V> && Event::effect == Effect::end) {
                if (!Event::exists(task_)) return;
                const std::uint64_t beyond = lanes & ~ended & to_bits(Event::starts_beyond(task_, ahead.start));
                writer_.end_rays(last, beyond, Event::status);
                ended |= beyond;
            }
        });
        if (ended) packet_.deactivate(ended);
        return ended;
    }

    /// How often in a row the step of a ray is halved, or taken again with another length, before the ray fails.
    static constexpr int max_halvings = 24, max_rejections = 60;
    /// The same for all halvings of a ray: one that advances by halvings alone would hardly ever end.
    static constexpr int max_halvings_of_ray = 4000;

    const Task<V>& task_;
    Packet<V>& packet_;
    RayEndWriter<V>& writer_;
    StepLength<V> length_;
    std::uint64_t repeated_ = 0;  ///< lanes whose step has been taken again
    std::uint64_t rejected_ = 0;  ///< lanes whose step has been rejected by `repeat`
    std::uint8_t halvings_[W] = {}, rejections_[W] = {};
    std::uint16_t halvings_of_ray_[W] = {};
};

}  // namespace kagero
