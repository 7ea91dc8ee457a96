/// The rays of one packet: a state for each lane, and what is counted of each ray.
///
/// An inactive lane has no ray, or its ray has ended or is set aside. It holds a finite state and steps of length zero,
/// so that steppers need no masks.
#pragma once

#include "kernels/methods/task.h"
#include "kernels/trace/ray_source.h"

namespace kagero {

template <class V>
struct Packet {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

    StepperState<V> state;     ///< where the rays are, and the step that they take
    V step_length;             ///< what the method or its step control proposes; 0 in inactive lanes
    V steps;                   ///< steps taken by each ray: whole numbers
    V worst_energy;            ///< the greatest relative error of H so far
    V iterations_at_end;       ///< StepperState::open_iterations when the lane became inactive: idle lanes count on
    std::uint64_t active = 0;  ///< lanes whose rays take steps
    std::uint64_t filled = 0;  ///< lanes that have, or had, a ray
    RayEnd* ends[W];           ///< where the ends of the rays are written
    std::uint64_t numbers[W];  ///< of the rays in their list or picture, where paths are reported

    /// Inactive lanes take over the state of an active one, with steps of length zero.
    void neutralize_lanes(std::uint64_t lanes) {
        if (!active || !lanes) return;
        const int donor = __builtin_ctzll(active);
        for (int i = 0; i < W; ++i) {
            if (!((lanes >> i) & 1)) continue;
            const auto copy = [&](V& v, const V& from) { set_lane(v, i, get_lane(from, donor)); };
            RayState<V>::each(state.start, state.start, copy);
            for (auto& stage : state.stage)
                for (V& g : stage) copy(g, g);
        }
    }
    /// Rays of `lanes` have ended at the start of their step.
    void deactivate(std::uint64_t lanes) {
        const MaskOf<V> gone = from_bits<V>(lanes);
        state.h = select(gone, V(S(0)), state.h);
        step_length = select(gone, V(S(0)), step_length);
        active &= ~lanes;
        neutralize_lanes(lanes);
    }
    /// Counts a step that the rays of `lanes` have taken.
    KAGERO_INLINE void count_step(std::uint64_t lanes) {
        const MaskOf<V> moved = from_bits<V>(lanes);
        steps = select(moved, steps + V(S(1)), steps);
        if (state.options.want_energy) {
            const MaskOf<V> inside = moved & (state.end.domain > V(S(0)));
            worst_energy = select(inside, max(worst_energy, state.energy_error), worst_energy);
        }
    }
};

/// What the stepper remembers of its last step, in the lanes of `lanes`.
template <class V>
void take_stages(StepperState<V>& to, const StepperState<V>& from, const MaskOf<V>& lanes) {
    for (int i = 0; i < max_stages; ++i)
        for (int k = 0; k < phase_size; ++k) to.stage[i][k] = select(lanes, from.stage[i][k], to.stage[i][k]);
}

/// Finite exactly where state and velocity are finite (apart from sums that overflow; no ray survives those either).
template <class V>
KAGERO_INLINE V sum_of_all(const State<V>& s, const Vec3<V>& v) {
    const Vec3<V> q = s.q(), p = s.p();
    return (v.x + v.y + v.z) + (q.x + q.y + q.z) + (p.x + p.y + p.z);
}

}  // namespace kagero
