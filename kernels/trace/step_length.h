/// Step lengths: the lengths that the method proposes, limited by the bounds of the space and the job.
#pragma once

#include "kernels/events/limits.h"
#include "kernels/methods/task.h"
#include "kernels/observers/charts.h"

#include <algorithm>
#include <cmath>

namespace kagero {

/// Returns the length of a step that takes a straight ray slightly beyond its exit from the escape sphere. A ray from
/// outside that misses the sphere gets a step to its point nearest to the origin. Every straight ray ends within two
/// such steps.
template <class V>
KAGERO_INLINE V straight_exit_length(const Task<V>& task, const RayState<V>& start) {
    using S = ScalarOf<V>;
    const Vec3<V> q = start.q(), v = start.velocity;
    const V inverse = recip(dot(v, v)), along = dot(q, v) * inverse, radius = task.escape_radius;
    const V length = fast_sqrt(max(fma(along, along, inverse * (radius * radius - dot(q, q))), V(S(0)))) - along;
    return max(length, fast_sqrt(dot(q, q) * inverse) * V(S(1e-3))) * V(S(1.001));
}

/// Computes the lengths of steps from the proposed lengths.
template <class V>
class StepLength {
    using S = ScalarOf<V>;

public:
    explicit StepLength(const Task<V>& task)
        : task_(task),
          has_bounds_(task.straight || task.kernel.bounds_steps || std::isfinite(task.job.bending_radius) ||
                      ParameterLimit::exists(task)) {
        if (task.job.chart_radius > 0) set_horizons();
    }

    /// Returns the lengths of the next steps from `start`, given the proposed lengths. The rays of `ingoing` are in
    /// ingoing coordinates.
    V operator()(const RayState<V>& start, const V& proposed, std::uint64_t ingoing) const {
        return has_bounds_ ? bounded_length(start, proposed, ingoing) : proposed;
    }

private:
    /// Applies all bounds to the proposed lengths. A straight ray gets one step to the escape sphere. A ray outside the
    /// sphere of radius Job::bending_radius is straight up to that sphere and gets one step up to it.
    V bounded_length(const RayState<V>& start, const V& proposed, std::uint64_t ingoing) const {
        const Job& job = task_.job;
        V h = proposed;
        if (task_.straight) h = select(proposed > V(S(0)), straight_exit_length(task_, start), V(S(0)));
        if (task_.kernel.bounds_steps && !task_.straight) h = limit_to_step_bound(start, h, ingoing);
        if (std::isfinite(job.bending_radius) && !task_.straight) {
            const V straight = min(straight_entry_length(start), straight_exit_length(task_, start));
            h = select(proposed > V(S(0)), max(h, straight), h);
        }
        return ParameterLimit::exists(task_) ? ParameterLimit::limited_length(task_, start, h) : h;
    }
    /// Limits |h dq/dτ| to the step bound of the Hamiltonian and, for adaptive methods, to Job::max_step_length and
    /// `longest_adaptive_step`.
    V limit_to_step_bound(const RayState<V>& start, const V& h, std::uint64_t ingoing) const {
        V bound = start.max_step_length;
        if (task_.job.chart_radius > 0) {
            const MaskOf<V> is_regular = from_bits<V>(task_.job.changes_chart_at_turns ? ~std::uint64_t(0) : ingoing);
            bound = select(is_regular, max(bound, chart_step_bound(start)), bound);
        }
        if (task_.method.info.adaptive) {
            bound = min(bound, V(S(task_.job.max_step_length)));
            if (std::isfinite(task_.job.max_step_radius_ratio)) bound = min(bound, longest_adaptive_step(start));
        }
        const V square = dot(start.velocity, start.velocity);
        const MaskOf<V> exceeds = h * h * square > bound * bound;
        return any(exceeds) ? select(exceeds, bound / sqrt(square), h) : h;
    }
    /// Returns half of |q| outside the horizon of a spinning hole. Inside, returns ½ Σ/(r + |a|), about the distance
    /// from the ring singularity (kernels/hamiltonians/kerr.h). The step bound of the hole, which is small near the
    /// horizon, is for rays that are singular there; rays that change their chart are not.
    V chart_step_bound(const RayState<V>& start) const {
        const Vec3<V> q = start.q(), stretched{q.x, q.y, stretch_ * q.z};  // the horizon is a spheroid
        const MaskOf<V> outside = dot(stretched, stretched) > squared_equator_;
        const V half(S(0.5)), a = spin_, square = dot(q, q), b = square - a * a, az = V(S(2)) * a * q.z,
                             sigma = sqrt(fma(b, b, az * az)), r = sqrt(max(half * (b + sigma), V(S(0))));
        return half * select(outside, sqrt(square), sigma / (r + a));
    }
    /// Sets the numbers of the horizon of each lane.
    void set_horizons() {
        for (int i = 0; i < lane_count<V>; ++i) {
            const Hole& hole = hole_of(task_.job, i);
            const double equator = charts::horizon_extent(hole);
            set_lane(squared_equator_, i, S(equator * equator));
            set_lane(stretch_, i, S(equator / charts::horizon_radius(hole)));
            set_lane(spin_, i, S(std::abs(hole.spin)));
        }
    }
    /// Returns Job::max_step_radius_ratio times |q| plus 1e-4 of the escape radius. The second term lets a ray pass the
    /// origin.
    V longest_adaptive_step(const RayState<V>& start) const {
        const Vec3<V> q = start.q();
        return fma(V(S(task_.job.max_step_radius_ratio)), sqrt(dot(q, q)), V(S(1e-4 * task_.job.escape_radius)));
    }
    /// Returns the length of the straight part of a ray, up to the sphere of radius Job::bending_radius. It is 0 inside
    /// the sphere, and the greatest number if the ray misses the sphere. The test for a miss uses |q × v|, which is
    /// more accurate in float than the difference of two squares.
    V straight_entry_length(const RayState<V>& start) const {
        const Vec3<V> q = start.q(), v = start.velocity, moment = cross(q, v);
        const V zero(S(0)), square = V(S(task_.job.bending_radius) * S(task_.job.bending_radius)),
                            excess2 = dot(q, q) - square, inward_rate = -dot(q, v);
        const V depth2 = square * dot(v, v) - dot(moment, moment);
        const MaskOf<V> enters = (inward_rate > zero) & (depth2 > zero);
        const V entry = excess2 / (inward_rate + fast_sqrt(max(depth2, zero)));
        return select(excess2 > zero, select(enters, entry, V(std::numeric_limits<S>::max())), zero);
    }

    const Task<V>& task_;
    const bool has_bounds_;  ///< False if every step has its proposed length.
    /// The square of the equatorial radius of the horizon, this radius divided by that at the poles, and |a|. Set only
    /// if rays can change their chart.
    V squared_equator_ = S(0), stretch_ = S(0), spin_ = S(0);
};

}  // namespace kagero
