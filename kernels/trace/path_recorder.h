/// Records what a job requests along rays in addition to their ends: integrals, and points of paths at even intervals
/// of λ. The tracing loop passes every accepted step to the recorder, and the part of a step up to a refined event. The
/// functions are not inlined, so that the loop stays small.
#pragma once

#include "kernels/events/deferred_events.h"
#include "kernels/trace/path_integrals.h"
#include "kernels/trace/ray_end_writer.h"

namespace kagero {

/// Recorder for the rays of one packet.
template <class V>
class PathRecorder {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    PathRecorder(const Task<V>& task, Packet<V>& packet, RayEndWriter<V>& writer)
        : integrals(task), records(integrals.requested || has_interval(task.job)), interval_(task.job.path_interval),
          reports_(has_interval(task.job)), task_(task), packet_(packet), writer_(writer) {}

    const PathIntegrals<V> integrals;
    const bool records;  ///< False if the job requests nothing that this class records.

    /// Prepares the recording of new rays in `lanes`.
    __attribute__((noinline)) void begin(std::uint64_t lanes) {
        if (integrals.requested) packet_.integrals.clear(from_bits<V>(lanes));
        if (reports_)
            for (const int i : lanes_in(lanes)) begin_points(i);
        const std::uint64_t ingoing = lanes & packet_.state.ingoing;
        packet_.from_inside &= ~lanes;
        for (const int i : lanes_in(ingoing))
            if (charts::is_inside(hole_of(task_.job, i), chart_state(packet_.state.start, i).q))
                packet_.from_inside |= std::uint64_t(1) << i;
        change_chart(packet_.state.start, ingoing & ~packet_.from_inside, false, true);
    }
    /// Records the whole step of the packet in `lanes`.
    __attribute__((noinline)) void add_step(std::uint64_t lanes) {
        const StepperState<V>& step = packet_.state;
        if (reports_) report_points(step, step.end, step.h, lanes);
        if (integrals.requested) integrals.add_step(step, from_bits<V>(lanes), packet_.integrals);
    }
    /// Records the part of the step `whole` that ends at the refined event of `deferred`, in `lanes`.
    template <class Events>
    __attribute__((noinline)) void add_part(const Step<V>& whole, const DeferredEvents<V, Events>& deferred,
                                            std::uint64_t lanes) {
        if (!lanes) return;
        const RayState<V>& end = deferred.step.end;
        const V length = deferred.event_fraction * whole.h;
        if (reports_) report_points(whole, end, length, lanes);
        if (!integrals.requested) return;
        IntegralPair<V> increment;
        integrals.up_to(whole, end, length, from_bits<V>(lanes), increment);
        packet_.integrals.add(increment, from_bits<V>(lanes));
    }

    /// Converts the integrals of `lanes` to the other chart, at the states at which the rays change their chart.
    void change_chart(const RayState<V>& states, std::uint64_t lanes, bool from_ingoing, bool states_are_ingoing) {
        if (!integrals.requested) return;
        for (const int i : lanes_in(lanes)) {
            const Hole& hole = hole_of(task_.job, i);
            const charts::State state = chart_state(states, i);
            const double r = charts::radius(hole, state.q), pt = states_are_ingoing ? -state.pt : state.pt;
            double action = packet_.integrals.of_lane(0, i), time = packet_.integrals.of_lane(1, i);
            (from_ingoing ? charts::integrals_to_outgoing : charts::integrals_to_ingoing)(hole, r, pt, action, time);
            packet_.integrals.set_in_lane(0, i, action);
            packet_.integrals.set_in_lane(1, i, time);
        }
    }

private:
    static bool has_interval(const Job& job) { return job.path_sink && job.path_interval > 0; }

    /// Prepares the points of the ray in lane i. A point at its start belongs to the segment of its path before it.
    void begin_points(int i) {
        offset_[i] = task_.job.path_offsets ? task_.job.path_offsets[packet_.ray_indices[i]] : 0;
        next_[i] = static_cast<std::uint32_t>(offset_[i] * (1 + rounding) / interval_) + 1;
    }
    /// Reports the points at multiples of the interval in the part of the step `whole` that ends at the state `end`, at
    /// the step length `length`.
    void report_points(const Step<V>& whole, const RayState<V>& end, const V& length, std::uint64_t lanes) {
        alignas(64) double last[W], targets[W] = {};
        to_doubles(end.parameter, last);
        while (true) {
            std::uint64_t due = 0;
            for (const int i : lanes_in(lanes)) {
                const double point = double(next_[i]) * interval_;
                targets[i] = point - offset_[i];
                if (point <= (last[i] + offset_[i]) * (1 + rounding)) due |= std::uint64_t(1) << i;
            }
            if (!due) return;
            const MaskOf<V> mask = from_bits<V>(due);
            const V target = lanes_of<V>(targets);
            StepperState<V> part = step_to_parameter(whole, end, length, target, mask);
            part.end.parameter = target;
            PathSums<V> sums = packet_.integrals;
            if (integrals.requested) integrals.add_step(part, mask, sums);
            writer_.report_points(part, part.end, sums, due, [&](int i) { return next_[i]; });
            for (const int i : lanes_in(due)) ++next_[i];
        }
    }
    /// Returns the part of the step `whole` that ends at λ = `target`. Without time rescaling, λ is linear in the step
    /// length. Otherwise, the secant method finds the length.
    StepperState<V> step_to_parameter(const Step<V>& whole, const RayState<V>& end, const V& length, const V& target,
                                      const MaskOf<V>& lanes) const {
        constexpr int max_corrections = 12;
        const V zero(S(0)), tolerance = V(S(4) * machine_epsilon<S>) * abs(target);
        const V share = (target - whole.start.parameter) / (end.parameter - whole.start.parameter);
        V h = select(lanes & is_finite(share), share * length, zero), last_h(zero),
          last_parameter = whole.start.parameter;
        for (int i = 0;; ++i) {
            StepperState<V> part = integrals.partial_step(whole, h);
            const V rest = target - part.end.parameter,
                    change = rest * (h - last_h) / (part.end.parameter - last_parameter);
            const MaskOf<V> open = lanes & (abs(rest) > tolerance) & is_finite(change);
            if (i == max_corrections || !any(open)) return part;
            last_h = select(open, h, last_h);
            last_parameter = select(open, part.end.parameter, last_parameter);
            h = select(open, h + change, h);
        }
    }

    static constexpr double rounding = 4 * double(machine_epsilon<S>);  ///< Relative rounding error of λ.
    const double interval_;
    const bool reports_;  ///< Points at multiples of `interval_` are reported.
    const Task<V>& task_;
    Packet<V>& packet_;
    RayEndWriter<V>& writer_;
    std::uint32_t next_[W];  ///< For each lane, the number of the next point.
    double offset_[W];       ///< For each lane, λ of the path at the start of the ray.
};

}  // namespace kagero
