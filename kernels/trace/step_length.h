/// The lengths of steps: what the method proposes, within the bounds of space and job.
#pragma once

#include "kernels/events/limits.h"
#include "kernels/methods/task.h"

#include <algorithm>
#include <cmath>

namespace kagero {

/// How long straight rays take to the escape sphere, and a little more; twice the distance where a ray comes in from
/// outside. Every straight ray ends within two such steps.
template <class V>
KAGERO_INLINE V straight_way_out(const Task<V>& task, const RayState<V>& start) {
    using S = ScalarOf<V>;
    const Vec3<V> q = start.q(), v = start.velocity;
    const V inverse = recip(dot(v, v)), along = dot(q, v) * inverse, radius = V(S(task.job.escape_radius));
    const V way = root(max(fma(along, along, inverse * (radius * radius - dot(q, q))), V(S(0)))) - along;
    return max(way, root(dot(q, q) * inverse) * V(S(1e-3))) * V(S(1.001));
}

template <class V>
class StepLength {
    using S = ScalarOf<V>;

public:
    explicit StepLength(const Task<V>& task)
        : task_(task), bounded_(task.straight || task.kernel.bounds_steps || std::isfinite(task.job.bends_within) ||
                                ParameterLimit::exists(task)) {}

    /// The lengths of the next steps from `start`, for proposed ones.
    V operator()(const RayState<V>& start, const V& proposed) const {
        return bounded_ ? bounded_length(start, proposed) : proposed;
    }

private:
    /// Rays that are straight, or straight at first, go to the escape sphere, or as far as they are straight, with one
    /// step.
    V bounded_length(const RayState<V>& start, const V& proposed) const {
        const Job& job = task_.job;
        V h = proposed;
        if (task_.straight) h = select(proposed > V(S(0)), straight_way_out(task_, start), V(S(0)));
        if (task_.kernel.bounds_steps && !task_.straight) h = within_scale(start, h);
        if (std::isfinite(job.bends_within) && !task_.straight)
            h = select(proposed > V(S(0)), max(h, min(straight_way_in(start), straight_way_out(task_, start))), h);
        return ParameterLimit::exists(task_) ? ParameterLimit::bounded(task_, start, h) : h;
    }
    /// No step is longer than the greatest step length that the Hamiltonian states.
    V within_scale(const RayState<V>& start, const V& h) const {
        V scale = start.max_step_length;
        if (std::isfinite(task_.job.longest_share) && task_.method.info.adaptive)
            scale = min(scale, longest_leap(start));
        const V square = dot(start.velocity, start.velocity);
        const MaskOf<V> longer = h * h * square > scale * scale;
        return any(longer) ? select(longer, scale / sqrt(square), h) : h;
    }
    /// Job::longest_share of |q|, and a ten-thousandth of the escape radius, so that a ray gets past the origin.
    V longest_leap(const RayState<V>& start) const {
        const Vec3<V> q = start.q();
        return fma(V(S(task_.job.longest_share)), sqrt(dot(q, q)), V(S(1e-4 * task_.job.escape_radius)));
    }
    /// How long rays are straight until they reach the sphere Job::bends_within: 0 inside it, and very long where they
    /// miss it. Whether a ray misses it follows from |q × v|, which is more exact in float than the difference of two
    /// squares.
    V straight_way_in(const RayState<V>& start) const {
        const Vec3<V> q = start.q(), v = start.velocity, moment = cross(q, v);
        const V zero(S(0)), square = V(S(task_.job.bends_within) * S(task_.job.bends_within)),
                            height = dot(q, q) - square, inward = -dot(q, v);
        const V depth = square * dot(v, v) - dot(moment, moment);
        const MaskOf<V> meets = (inward > zero) & (depth > zero);
        return select(height > zero,
                      select(meets, height / (inward + root(max(depth, zero))), V(std::numeric_limits<S>::max())),
                      zero);
    }

    const Task<V>& task_;
    const bool bounded_;  ///< a step may have another length than the proposed one
};

}  // namespace kagero
