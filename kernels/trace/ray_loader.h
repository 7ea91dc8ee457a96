/// Loads new rays into lanes. Ends the rays that are beyond an event at their start.
#pragma once

#include "kernels/events/all_events.h"
#include "kernels/trace/ray_end_writer.h"

#include <cmath>

namespace kagero {

/// Loads the rays of one packet.
template <class V, class Events = AllEvents>
class RayLoader {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    RayLoader(const Task<V>& task, Packet<V>& packet, RayEndWriter<V>& writer)
        : task_(task), packet_(packet), writer_(writer) {}

    /// Loads the first rays of a packet into `lanes`. Other lanes get a copy of one of these rays.
    void load_first(RayStarts<W>& starts, std::uint64_t lanes) {
        StepperState<V>& state = packet_.state;
        set_options();
        packet_.filled = lanes;
        state.lane_iterations = packet_.iterations_of_ray = packet_.steps = packet_.step_length = state.h = V(S(0));
        write_starts(starts, lanes, state);
        state.ingoing = starts.ingoing & lanes;
        task_.begin(state);
        packet_.worst_energy_error = state.energy_error;
    }
    /// Loads new rays into `lanes`, whose previous rays have ended.
    void load_more(RayStarts<W>& starts, std::uint64_t lanes) {
        StepperState<V>& state = packet_.state;
        StepperState<V> fresh = state;
        write_starts(starts, lanes, fresh);
        task_.begin(fresh);
        const MaskOf<V> mask = from_bits<V>(lanes);
        state.copy_lanes(fresh, mask);
        copy_stages(state, fresh, mask);
        state.ingoing = (state.ingoing & ~lanes) | (starts.ingoing & lanes);
        packet_.filled |= lanes;
        packet_.steps = select(mask, V(S(0)), packet_.steps);
        state.lane_iterations = select(mask, V(S(0)), state.lane_iterations);
        packet_.worst_energy_error = select(mask, state.energy_error, packet_.worst_energy_error);
    }
    /// Activates the new rays of `lanes`. Ends the rays that cannot be traced or that start beyond an event.
    void activate(const RayStarts<W>& starts, std::uint64_t lanes) {
        StepperState<V>& state = packet_.state;
        std::uint64_t usable = lanes & to_bits(is_finite(sum_of_all(state.start, state.start.velocity)));
        usable &= ~(starts.captured | starts.escaped | starts.failed);
        if (task_.job.path_sink) writer_.report_path(state, usable, true);
        const std::uint64_t beyond = usable & to_bits(starts_beyond_an_event());
        if (lanes != (usable & ~beyond)) state.end = state.start;  // for the rays that end at their start
        end_unusable(starts, lanes & ~usable);
        if (beyond) end_at_events(beyond);
        packet_.active |= usable & ~beyond;
        packet_.neutralize_lanes(all_lane_bits<W> & ~packet_.active & ~usable);
    }

    /// Continues the rays of `lanes` from `state_at_event`, after a refined event of `step`.
    void resume(const RayState<V>& state_at_event, const StepEnd<V>& step, std::uint64_t lanes) {
        StepperState<V>& state = packet_.state;
        const MaskOf<V> mask = from_bits<V>(lanes);
        StepperState<V> fresh = state;
        RayState<V>::for_each_number(fresh.start, state_at_event, CopyLanes<V>{mask});
        // The motion in the orbit plane follows from q and p, and from their rounding errors in the memory, here 0.
        if (task_.method.info.angular)
            for (V& number : fresh.start.stepper_memory) number = V(S(0));
        task_.begin(fresh);
        fresh.gradients = select(mask, step.gradients, fresh.gradients);
        state.copy_lanes(fresh, mask);
        copy_stages(state, fresh, mask);
        state.lane_iterations = select(mask, packet_.iterations_of_ray, state.lane_iterations);
        packet_.record_energy_error(step.energy_error, mask);
        packet_.active |= lanes;
    }

private:
    /// Sets the options of the steps from the job.
    void set_options() {
        const Job& job = task_.job;
        StepperState<V>& state = packet_.state;
        state.options.compute_energy_error = !task_.straight && (job.outputs & output_energy) != 0;
        state.options.compute_energy = job.path_sink;
        state.options.test_energy = !task_.straight;
        state.options.use_symmetry = job.use_symmetry;
        state.options.capture_radius = S(job.capture_radius);
        state.options.capture_stretch = S(job.capture_stretch);
        state.options.compute_carried =
            (job.outputs & output_parameter) != 0 || job.path_sink || std::isfinite(job.parameter_limit);
        state.options.solver_tolerance = S(job.solver_tolerance);
        state.options.tolerance = S(job.tolerance);
        state.options.position_scale = S(job.position_scale);
        state.options.momentum_scale = S(job.momentum_scale);
        state.options.value_weight = S(job.value_weight);
    }
    /// Writes the starts of the rays in `lanes` into a state. Other lanes get a copy of one of these starts.
    void write_starts(RayStarts<W>& starts, std::uint64_t lanes, StepperState<V>& state) const {
        const V zero(S(0));
        starts.fill_idle_lanes(lanes);
        for (V& value : state.start.stepper_memory) value = zero;
        // Integration in the orbit plane requires more digits than floats have. `stepper_memory` therefore stores the
        // rounding errors of the conversion from double.
        for (int k = 0; k < phase_size; ++k)
            state.start.y[k] =
                task_.method.info.angular ? lanes_of<V>(starts.y[k], state.start.stepper_memory[k])
                                          : lanes_of<V>(starts.y[k]);
        state.start.pt() = lanes_of<V>(starts.y[component_pt]);
        state.start.parameter = state.end.parameter = state.gradients = state.energy_error = state.energy = zero;
        for (V* rounding : {state.start.carried_rounding, state.end.carried_rounding}) rounding[0] = zero;
    }

    /// True if the event ends rays that start beyond it.
    template <class Event>
    static constexpr bool ends_rays_at_start = Event::effect ==
                                               Effect::end&& requires(const Task<V>& task, const RayState<V>& start) {
        Event::starts_beyond(task, start);
    };

    /// Returns the lanes whose ray starts beyond at least one event.
    MaskOf<V> starts_beyond_an_event() const {
        MaskOf<V> beyond = no_lanes<V>();
        Events::each([&]<class Event>() {
            if constexpr (ends_rays_at_start<Event>)
                if (Event::exists(task_)) beyond = beyond | Event::starts_beyond(task_, packet_.state.start);
        });
        return beyond;
    }
    /// Ends the rays of `lanes` at their start, each with the status of the first event that it starts beyond.
    void end_at_events(std::uint64_t lanes) {
        Events::each([&]<class Event>() {
            if constexpr (ends_rays_at_start<Event>) {
                if (!lanes || !Event::exists(task_)) return;
                const std::uint64_t ended = lanes & to_bits(Event::starts_beyond(task_, packet_.state.start));
                writer_.end_rays(packet_.state, ended, Event::status);
                lanes &= ~ended;
            }
        });
    }
    /// Ends rays that cannot be traced: their RayStart states how they end, or the state at their start is not finite.
    void end_unusable(const RayStarts<W>& starts, std::uint64_t lanes) {
        for (const int i : lanes_in(lanes)) {
            const std::uint64_t lane = std::uint64_t(1) << i;
            if (starts.captured & lane) {
                writer_.end_rays(packet_.state, lane, Status::captured);
            } else if (starts.escaped & lane) {
                writer_.end_far_away(starts, i);
            } else {
                const Failure failure = starts.failed & lane ? starts.failure[i] : Failure::singular_start;
                writer_.fail_at_start(lane, failure);
            }
        }
    }

    const Task<V>& task_;
    Packet<V>& packet_;
    RayEndWriter<V>& writer_;
};

}  // namespace kagero
