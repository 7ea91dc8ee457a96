/// Changes between the two charts of a spinning black hole. Near the horizon, rays that move outward are regular only
/// in ingoing coordinates, and rays that move inward only in outgoing ones (kernels/observers/charts.h). A ray can
/// therefore be in ingoing coordinates inside the sphere |q| = Job::chart_radius. Outside, all rays are in outgoing
/// coordinates. The sphere contains no surfaces, except inside the horizon.
#pragma once

#include "kernels/events/event.h"
#include "kernels/observers/charts.h"
#include "kernels/simd/bits.h"

namespace kagero {

/// Returns the state of one lane.
template <class V>
charts::State chart_state(const RayState<V>& from, int lane) {
    charts::State state;
    for (int k = 0; k < space_size; ++k) {
        state.q[k] = double(get_lane(from.y[k], lane));
        state.p[k] = double(get_lane(from.y[momentum(k)], lane));
    }
    state.v[0] = double(get_lane(from.velocity.x, lane));
    state.v[1] = double(get_lane(from.velocity.y, lane));
    state.v[2] = double(get_lane(from.velocity.z, lane));
    state.pt = double(get_lane(from.pt(), lane));
    return state;
}
/// Changes the states of `lanes` from the chart of the kernel in which they are to the other chart.
template <class V>
void change_chart(const Job& job, RayState<V>& states, std::uint64_t lanes, bool are_ingoing) {
    using S = ScalarOf<V>;
    for (const int i : lanes_in(lanes)) {
        const Hole& hole = hole_of(job, i);
        charts::State state = chart_state(states, i);
        are_ingoing ? charts::to_scene(hole, state) : charts::to_ingoing(hole, state);
        for (int k = 0; k < space_size; ++k) {
            set_lane(states.y[k], i, S(state.q[k]));
            set_lane(states.y[momentum(k)], i, S(state.p[k]));
        }
        set_lane(states.pt(), i, S(state.pt));
        for (V& number : states.stepper_memory) set_lane(number, i, S(0));
    }
}

/// A ray in ingoing coordinates leaves the sphere and continues in outgoing coordinates.
struct ChartSphere {
    static constexpr Effect effect = Effect::resume;
    /// The ray changes between ingoing and outgoing coordinates.
    static constexpr bool changes_chart = true;

    template <class V>
    static bool exists(const Task<V>& task) {
        return task.job.chart_radius > 0;
    }
    template <class V>
    KAGERO_INLINE static V squared_radius(const Task<V>& task) {
        return V(ScalarOf<V>(task.job.chart_radius * task.job.chart_radius));
    }
    /// Returns the lanes in which the event can take place on this step.
    template <class V>
    KAGERO_INLINE static MaskOf<V> applies_to(const Step<V>& step) {
        return from_bits<V>(step.ingoing);
    }
    template <class V>
    KAGERO_INLINE static MaskOf<V> possible(const Task<V>& task, const Step<V>& step, const V&) {
        const Vec3<V> q = step.end.q();
        return applies_to(step) & (dot(q, q) >= squared_radius(task));
    }
    template <class V>
    static LevelSet<V> level_set(const Task<V>& task) {
        return sphere_level_set(V(ScalarOf<V>(task.job.chart_radius)));
    }
    template <class V>
    static MaskOf<V> crossed_before(const Task<V>& task, const RayState<V>& start, const RayState<V>& at) {
        using S = ScalarOf<V>;
        constexpr S uncertainty = ValueEvent<ChartSphere>::template value_uncertainty<S>;
        const Vec3<V> a = start.q(), q = at.q();
        const V square = squared_radius(task);
        return (dot(a, a) < square) & (dot(q, q) > V(S(1 + uncertainty)) * square);
    }
    template <class V>
    static void resume(const Task<V>& task, RayState<V>& at, std::uint64_t lanes) {
        change_chart(task.job, at, lanes, true);
    }
};

/// Returns the lanes of `active` whose ray is inside the sphere and outside the horizon, but not in the chart in which
/// it is regular, or outside the sphere in ingoing coordinates. A ray that moves outward in outgoing coordinates counts
/// only if Job::changes_chart_at_turns is set.
template <class V>
std::uint64_t lanes_in_wrong_chart(const Task<V>& task, const Step<V>& step, std::uint64_t active) {
    const RayState<V>& start = step.start;
    const Vec3<V> q = start.q();
    const std::uint64_t inside = active & to_bits(dot(q, q) < ChartSphere::squared_radius(task));
    std::uint64_t wrong = inside | (active & step.ingoing);
    for (const int i : lanes_in(inside)) {
        const Hole& hole = hole_of(task.job, i);
        const charts::State state = chart_state(start, i);
        const double a2 = hole.spin * hole.spin, r = charts::radius(hole, state.q),
                     horizon = charts::horizon_radius(hole);
        // dr/dλ has the sign of r² q·v + a² z v_z.
        const double *x = state.q, *v = state.v,
                     radial = r * r * (x[0] * v[0] + x[1] * v[1] + x[2] * v[2]) + a2 * x[2] * v[2];
        const bool is_ingoing = (step.ingoing >> i) & 1;
        const bool is_wrong = is_ingoing ? radial <= 0 : radial > 0 && task.job.changes_chart_at_turns;
        if (r <= (1 + 1e-9) * horizon || !is_wrong) wrong &= ~(std::uint64_t(1) << i);
    }
    return wrong;
}

}  // namespace kagero
