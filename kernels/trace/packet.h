/// The rays of one packet: one state for each lane, and counters for each ray.
///
/// A lane is inactive if it has no ray, if its ray has ended, or if its event is deferred. An inactive lane holds a
/// finite state and takes steps of length zero, so that steppers need no masks.
#pragma once

#include "kernels/methods/task.h"
#include "kernels/trace/ray_source.h"

namespace kagero {

/// The integrals along the rays of a packet, RayEnd::action and RayEnd::time. The rounding errors of the sums are kept,
/// so that many short steps lose no accuracy (Kahan 1965).
template <class V>
struct PathSums {
    V sum[2], rounding[2];

    /// Sets the sums of `lanes` to zero.
    void clear(const MaskOf<V>& lanes) {
        for (V* values : {sum, rounding})
            for (int k = 0; k < 2; ++k) values[k] = select(lanes, V(ScalarOf<V>(0)), values[k]);
    }
    /// Adds the numbers `increment` in the given lanes.
    void add(const V (&increment)[2], const MaskOf<V>& lanes) {
        for (int k = 0; k < 2; ++k) {
            const V corrected = increment[k] + rounding[k], total = sum[k] + corrected;
            rounding[k] = select(lanes, corrected - (total - sum[k]), rounding[k]);
            sum[k] = select(lanes, total, sum[k]);
        }
    }
    /// Sets the action (k = 0) or the time (k = 1) of one lane.
    void set_in_lane(int k, int lane, double value) {
        using S = ScalarOf<V>;
        set_lane(sum[k], lane, S(value));
        set_lane(rounding[k], lane, S(value - double(S(value))));
    }
    /// Returns the action (k = 0) or the time (k = 1) of one lane.
    double of_lane(int k, int lane) const {
        return double(get_lane(sum[k], lane)) + double(get_lane(rounding[k], lane));
    }
};

/// The rays of one packet.
template <class V>
struct Packet {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

    StepperState<V> state;         ///< States of the rays and their current step.
    V step_length;                 ///< Step length proposed by the method or its step control; 0 in inactive lanes.
    V steps;                       ///< Number of accepted steps of each ray.
    V worst_energy_error;          ///< Greatest energy error of each ray so far.
    /// Value of state.lane_iterations after the last step of each ray. In idle lanes, lane_iterations continues to
    /// increase.
    V iterations_of_ray;
    std::uint64_t active = 0;      ///< Lanes whose rays take steps.
    std::uint64_t filled = 0;      ///< Lanes that have, or have had, a ray.
    std::uint64_t from_inside = 0; ///< Lanes whose rays started inside the horizon of a black hole.
    RayEnd* ends[W];               ///< Destinations of the ray ends.
    std::uint64_t ray_indices[W];  ///< Indices of the rays in their list or picture; set only for lists and paths.
    PathSums<V> integrals;         ///< Set only if the job requests integrals along rays.

    /// Copies the state of an active lane into `lanes`, which are inactive and take steps of length zero.
    void neutralize_lanes(std::uint64_t lanes) {
        if (!active || !lanes) return;
        const int donor = __builtin_ctzll(active);
        for (int i = 0; i < W; ++i) {
            if (!((lanes >> i) & 1)) continue;
            const auto copy = [&](V& v, const V& from) { set_lane(v, i, get_lane(from, donor)); };
            RayState<V>::for_each_number(state.start, state.start, copy);
            for (auto& stage : state.stage)
                for (V& g : stage) copy(g, g);
        }
    }
    /// Deactivates `lanes`, whose rays have ended at the start of their step.
    void deactivate(std::uint64_t lanes) {
        const MaskOf<V> mask = from_bits<V>(lanes);
        state.h = select(mask, V(S(0)), state.h);
        step_length = select(mask, V(S(0)), step_length);
        active &= ~lanes;
        neutralize_lanes(lanes);
    }
    /// Counts one step of the rays of `lanes` and updates their energy errors.
    KAGERO_INLINE void count_step(std::uint64_t lanes) {
        const MaskOf<V> mask = from_bits<V>(lanes);
        steps = select(mask, steps + V(S(1)), steps);
        if (state.options.compute_energy_error) {
            const MaskOf<V> in_domain = mask & (state.end.domain > V(S(0)));
            record_energy_error(state.energy_error, in_domain);
        }
    }
    /// Updates the greatest energy errors of the rays of `lanes`.
    KAGERO_INLINE void record_energy_error(const V& error, const MaskOf<V>& lanes) {
        worst_energy_error = select(lanes, max(worst_energy_error, error), worst_energy_error);
    }
};

/// Copies the stage derivatives of the stepper in `lanes`.
template <class V>
void copy_stages(StepperState<V>& to, const StepperState<V>& from, const MaskOf<V>& lanes) {
    for (int i = 0; i < max_stages; ++i)
        for (int k = 0; k < phase_size; ++k) to.stage[i][k] = select(lanes, from.stage[i][k], to.stage[i][k]);
}

/// Returns a number that is not finite if a component of the state or the velocity is not finite. It also overflows for
/// finite components near the limit of the number type; such a ray is unusable too.
template <class V>
KAGERO_INLINE V sum_of_all(const State<V>& s, const Vec3<V>& v) {
    const Vec3<V> q = s.q(), p = s.p();
    return (v.x + v.y + v.z) + (q.x + q.y + q.z) + (p.x + p.y + p.z);
}

}  // namespace kagero
