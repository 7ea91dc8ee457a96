/// Loads new rays into lanes, and ends those that are beyond an event where they start.
#pragma once

#include "kernels/events/all_events.h"
#include "kernels/trace/ray_end_writer.h"

#include <cmath>

namespace kagero {

template <class V, class Events = AllEvents>
class RayLoader {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    RayLoader(const Task<V>& task, Packet<V>& packet, RayEndWriter<V>& writer)
        : task_(task), packet_(packet), writer_(writer) {}

    /// The first rays of a packet, in `lanes`. Other lanes repeat one of them.
    void load_first(RayStarts<W>& starts, std::uint64_t lanes) {
        StepperState<V>& state = packet_.state;
        set_options();
        packet_.filled = lanes;
        state.open_iterations = packet_.iterations_at_end = packet_.steps = packet_.step_length = state.h = V(S(0));
        place(starts, lanes, state);
        task_.begin(state);
        packet_.worst_energy = state.energy_error;
    }
    /// More rays, in lanes whose rays have ended.
    void load_more(RayStarts<W>& starts, std::uint64_t lanes) {
        StepperState<V>& state = packet_.state;
        StepperState<V> fresh = state;
        place(starts, lanes, fresh);
        task_.begin(fresh);
        const MaskOf<V> here = from_bits<V>(lanes);
        state.take(fresh, here);
        take_stages(state, fresh, here);
        packet_.filled |= lanes;
        packet_.steps = select(here, V(S(0)), packet_.steps);
        state.open_iterations = select(here, V(S(0)), state.open_iterations);
        packet_.worst_energy = select(here, state.energy_error, packet_.worst_energy);
    }
    /// Makes the new rays of `lanes` active, except those that end where they start.
    void activate(const RayStarts<W>& starts, std::uint64_t lanes) {
        StepperState<V>& state = packet_.state;
        std::uint64_t usable = lanes & to_bits(is_finite(sum_of_all(state.start, state.start.velocity)));
        usable &= ~(starts.captured | starts.escaped | starts.failed);
        if (task_.job.path_sink) writer_.report_path(state, usable, true);
        const std::uint64_t beyond = usable & to_bits(starts_beyond_an_event());
        if (lanes != (usable & ~beyond)) state.end = state.start;  // a ray that ends at once ends there
        end_unusable(starts, lanes & ~usable);
        if (beyond) end_at_events(beyond);
        packet_.active |= usable & ~beyond;
        packet_.neutralize_lanes(all_lanes<W> & ~packet_.active & ~usable);
    }

    /// Rays go on from another state, `at`, after a refined event of `step`.
    void resume(const RayState<V>& at, const StepEnd<V>& step, std::uint64_t lanes) {
        StepperState<V>& state = packet_.state;
        const MaskOf<V> here = from_bits<V>(lanes);
        StepperState<V> fresh = state;
        RayState<V>::each(fresh.start, at, CopyLanes<V>{here});
        task_.begin(fresh);
        fresh.gradients = select(here, step.gradients, fresh.gradients);
        state.take(fresh, here);
        take_stages(state, fresh, here);
        state.open_iterations = select(here, packet_.iterations_at_end, state.open_iterations);
        packet_.worst_energy = select(here, max(packet_.worst_energy, step.energy_error), packet_.worst_energy);
        packet_.active |= lanes;
    }

private:
    /// What steps have to compute.
    void set_options() {
        const Job& job = task_.job;
        StepperState<V>& state = packet_.state;
        state.options.want_energy = !task_.straight && (job.outputs & output_energy) != 0;
        state.options.want_path = job.path_sink;
        state.options.test_energy = !task_.straight;
        state.options.use_symmetry = job.use_symmetry;
        state.options.capture_within = S(job.capture_within), state.options.capture_stretch = S(job.capture_stretch);
        state.options.want_carried =
            (job.outputs & output_parameter) != 0 || job.path_sink || std::isfinite(job.parameter_limit);
        state.options.solver_tolerance = S(job.solver_tolerance);
        state.options.tolerance = S(job.tolerance);
    }
    /// Writes the starts of rays into a state. Lanes that are not in `lanes` repeat one that is.
    void place(RayStarts<W>& starts, std::uint64_t lanes, StepperState<V>& state) const {
        const V zero(S(0));
        starts.fill_up(lanes);
        for (V& c : state.start.carry) c = zero;
        // The plane of an orbit needs more digits than the packet has: `carry` holds the rest.
        for (int k = 0; k < phase_size; ++k)
            state.start.y[k] =
                task_.method.info.angular ? lanes_of<V>(starts.y[k], state.start.carry[k]) : lanes_of<V>(starts.y[k]);
        state.start.pt() = lanes_of<V>(starts.y[component_pt]);
        state.start.parameter = state.end.parameter = state.gradients = state.energy_error = state.energy = zero;
    }

    template <class Event>
    static constexpr bool ends_rays_at_start = Event::effect ==
                                               Effect::end&& requires(const Task<V>& task, const RayState<V>& start) {
        Event::starts_beyond(task, start);
    };

    MaskOf<V> starts_beyond_an_event() const {
        MaskOf<V> beyond = never<V>();
        Events::each([&]<class Event>() {
            if constexpr (ends_rays_at_start<Event>)
                if (Event::exists(task_)) beyond = beyond | Event::starts_beyond(task_, packet_.state.start);
        });
        return beyond;
    }
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
    /// Rays that cannot be traced: the camera or the observer states their end, or their start is not a finite state.
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
