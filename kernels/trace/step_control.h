/// Accepts or rejects steps. A rejected step is repeated with another length.
#pragma once

#include "kernels/events/all_events.h"
#include "kernels/trace/ray_end_writer.h"
#include "kernels/trace/stalled_rays.h"
#include "kernels/trace/step_length.h"

namespace kagero {

/// Controls the steps of one packet.
template <class V, class Events = AllEvents>
class StepControl {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    StepControl(const Task<V>& task, Packet<V>& packet, RayEndWriter<V>& writer)
        : task_(task), packet_(packet), writer_(writer), length_(task), stalled_(task.job) {}

    /// Resets the counters of `lanes` for new rays, which must have been loaded.
    void begin(std::uint64_t lanes) {
        repeated_ &= ~lanes;
        rejected_ &= ~lanes;
        keeping_length_ &= ~lanes;
        for (const int i : lanes_in(lanes)) {
            halvings_[i] = rejections_[i] = 0;
            halvings_of_ray_[i] = 0;
        }
        if (stalled_.exist) stalled_.begin(lanes, packet_.state.start);
    }
    /// Sets the first step lengths of the rays in `lanes`.
    void start_steps(std::uint64_t lanes) {
        const MaskOf<V> mask = from_bits<V>(lanes);
        V& proposed = packet_.step_length;
        proposed = select(mask, select(from_bits<V>(packet_.active), first_step(), V(S(0))), proposed);
        packet_.state.h = select(mask, next_length(), packet_.state.h);
    }
    /// Returns the lengths of the next steps.
    V next_length() const {
        return length_(packet_.state.start, packet_.step_length, packet_.state.ingoing);
    }

    /// Returns the lanes whose step is accepted. A step is rejected and halved if its implicit equations have no
    /// solution, if its end is not finite, or if it does not conserve H. A method with step control also rejects steps
    /// with too large an error and proposes another length. The steps of `excluded` have been rejected already.
    std::uint64_t accept(std::uint64_t excluded = 0) {
        const StepperState<V>& step = packet_.state;
        const std::uint64_t finite = to_bits(is_finite(sum_of_all(step.end, step.end.velocity))),
                            solved = to_bits(step.solved);
        const bool adaptive = task_.method.info.adaptive && !task_.straight;
        const std::uint64_t accepted = adaptive ? to_bits(step.accepted) : packet_.active;
        KAGERO_ASSERT((accepted & ~all_lane_bits<W>) == 0);
        // H is undefined beyond the edge of the medium.
        const std::uint64_t not_conserved =
            step.options.test_energy ? accepted & ~to_bits(step.energy_is_conserved | (step.end.domain <= V(S(0)))) : 0;
        const std::uint64_t tried = packet_.active & ~excluded;
        std::uint64_t moving = tried & finite & solved & ~not_conserved;
        if (moving != tried) halve(tried & ~moving, tried & ~solved, not_conserved & finite & solved);
        if (adaptive) {
            repeat(moving & ~accepted, step.suggested_length);
            moving &= accepted;
            // A short step that passes a kink says nothing about the length of the next one.
            const MaskOf<V> keeping = from_bits<V>(moving & keeping_length_);
            packet_.step_length = select(from_bits<V>(moving), step.suggested_length, packet_.step_length);
            packet_.step_length = select(keeping, kept_length_, packet_.step_length);
            keeping_length_ &= ~moving;
        }
        return stalled_.exist ? moving & ~end_stalled(moving) : moving;
    }
    /// Rejects the steps of `lanes` and schedules their repetition with another length. A ray fails after too many
    /// rejections in a row.
    void repeat(std::uint64_t lanes, const V& length) {
        if (!lanes) return;
        kept_length_ = select(from_bits<V>(lanes & ~rejected_), packet_.state.h, kept_length_);
        repeated_ |= lanes;
        rejected_ |= lanes;
        std::uint64_t failed = 0;
        for (const int i : lanes_in(lanes))
            if (++rejections_[i] >= max_rejections) failed |= std::uint64_t(1) << i;
        restart(lanes, length);
        if (failed) writer_.fail_rays(failed, failed, 0);
    }
    /// Keeps, after the accepted steps of `lanes`, the step length that these rays had before.
    void keep_length(std::uint64_t lanes) { keeping_length_ |= lanes; }
    /// Returns the lanes whose step is the first try from its start.
    std::uint64_t first_tries() const { return ~rejected_; }
    /// Resets the repetition counters of `lanes` after an accepted step.
    KAGERO_INLINE void reset_repetitions(std::uint64_t lanes) {
        for (const int i : lanes_in(lanes & repeated_)) halvings_[i] = rejections_[i] = 0;
        repeated_ &= ~lanes;
        rejected_ &= ~lanes;
    }

    /// Repeats the steps of `lanes` in `whole_step` with half their length, because their event could not be refined.
    /// Returns the lanes whose steps are repeated; the steps of the other lanes have been halved too often.
    std::uint64_t repeat_halved(const Step<V>& whole_step, std::uint64_t lanes) {
        constexpr std::uint16_t halvings_per_refinement = 16;  // a failed refinement costs several steps
        std::uint64_t again = 0;
        for (const int i : lanes_in(lanes)) {
            halvings_of_ray_[i] = static_cast<std::uint16_t>(halvings_of_ray_[i] + halvings_per_refinement);
            if (halvings_[i]++ < max_halvings && halvings_of_ray_[i] < max_halvings_of_ray)
                again |= std::uint64_t(1) << i;
        }
        if (!again) return 0;
        const MaskOf<V> mask = from_bits<V>(again);
        Packet<V>& packet = packet_;
        packet.state.copy_lanes(whole_step, mask);
        packet.step_length =
            select(mask, task_.method.info.adaptive ? whole_step.h : V(S(task_.job.step)), packet.step_length);
        packet.steps = select(mask, packet.steps - V(S(1)), packet.steps);
        packet.state.lane_iterations = select(mask, packet.iterations_of_ray, packet.state.lane_iterations);
        packet.active |= again;
        repeated_ |= again;
        restart(again, whole_step.h * V(S(0.5)));
        return again;
    }

private:
    /// Returns the steps that the rays take first.
    V first_step() const {
        const double length = task_.job.first_step_length;
        if (length == 0 || !task_.method.info.adaptive || task_.straight) return V(S(task_.job.step));
        const Vec3<V> v = packet_.state.start.velocity;
        const V square = dot(v, v);
        return select(square > V(S(0)), V(S(length)) / sqrt(square), V(S(task_.job.step)));
    }
    /// Ends those of `lanes` whose rays are stalled, as failed. Returns their lanes.
    std::uint64_t end_stalled(std::uint64_t lanes) {
        const std::uint64_t diverging = stalled_.with_diverging_momentum(packet_.state, packet_.state.end, 1, lanes),
                            vanishing = stalled_.with_vanishing_steps(packet_.state, lanes & ~diverging);
        if (diverging) writer_.fail_at_step_start(diverging, Failure::momentum_diverges);
        if (vanishing) writer_.fail_at_step_start(vanishing, Failure::steps_vanish);
        return diverging | vanishing;
    }
    /// Moves `lanes` back to the start of their step, with a new step length. Recomputes the stage derivatives that the
    /// stepper keeps there.
    void restart(std::uint64_t lanes, const V& length) {
        const MaskOf<V> mask = from_bits<V>(lanes);
        StepperState<V>& state = packet_.state;
        state.h = select(mask, length, state.h);
        if (task_.steps_without_begin) return;
        StepperState<V> restarted = state;
        task_.begin(restarted);
        copy_stages(state, restarted, mask);
    }
    /// Repeats the steps of `lanes` with half their length. After too many halvings, a ray ends at the event that it
    /// has almost reached, or it fails.
    void halve(std::uint64_t lanes, std::uint64_t unsolved, std::uint64_t not_conserved) {
        repeated_ |= lanes;
        std::uint64_t failed = 0, often_halved = 0;
        for (const int i : lanes_in(lanes)) {
            if (halvings_[i]++ >= max_halvings || halvings_of_ray_[i]++ >= max_halvings_of_ray)
                failed |= std::uint64_t(1) << i;
            if (is_often_halved(i)) often_halved |= std::uint64_t(1) << i;
        }
        if (stalled_.exist && often_halved) {
            const std::uint64_t growing = stalled_.with_growing_momentum(packet_.state, often_halved);
            writer_.fail_at_step_start(growing, Failure::momentum_diverges);
            lanes &= ~growing;
            failed &= ~growing;
        }
        if (failed) lanes &= ~end_at_edge(failed);
        restart(lanes, packet_.state.h * V(S(0.5)));
        if (failed &= lanes) writer_.fail_rays(failed, unsolved, not_conserved);
    }
    /// Returns true if the ray of a lane has been halved so often, or at such a cost, that it fails if its momentum
    /// grows. The stages of a rejected implicit step take hundreds of gradients.
    bool is_often_halved(int lane) const {
        const int halvings = halvings_of_ray_[lane];
        return halvings > max_halvings_while_growing ||
               (halvings > max_costly_halvings && get_lane(packet_.state.gradients, lane) > S(costly_gradients));
    }
    /// Ends those of `lanes` from whose position a step along the tangent leads beyond an event. If H is NaN beyond an
    /// event, every step across it is rejected. After many halvings, the ray is closer to the event than one step.
    /// Returns the lanes whose rays have ended.
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

    /// Numbers of halvings and of rejections in a row after which a ray fails.
    static constexpr int max_halvings = 24, max_rejections = 60;
    /// Total number of halvings after which a ray fails. A ray that needs many halvings in most of its steps would take
    /// very long.
    static constexpr int max_halvings_of_ray = 4000;
    /// Total numbers of halvings after which a ray fails whose momentum grows (StalledRays::with_growing_momentum). The
    /// second number is for rays that have taken more than `costly_gradients`.
    static constexpr int max_halvings_while_growing = 12, max_costly_halvings = 3, costly_gradients = 1500;

    const Task<V>& task_;
    Packet<V>& packet_;
    RayEndWriter<V>& writer_;
    StepLength<V> length_;
    StalledRays<V> stalled_;
    std::uint64_t repeated_ = 0;  ///< Lanes whose current step is a repetition with another length.
    std::uint64_t rejected_ = 0;  ///< Lanes whose step has been rejected by `repeat`.
    std::uint64_t keeping_length_ = 0;  ///< Lanes whose next step has the length `kept_length_`.
    V kept_length_ = S(0);              ///< Length of the first try of the step, if it was rejected.
    std::uint8_t halvings_[W] = {}, rejections_[W] = {};  ///< Counts for the current step of each lane.
    std::uint16_t halvings_of_ray_[W] = {};               ///< Halvings of all steps of each ray.
};

}  // namespace kagero
