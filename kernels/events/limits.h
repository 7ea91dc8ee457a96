/// The limits of a job on the parameter λ and on the number of steps. Both events take place at the end of a step.
#pragma once

#include "kernels/events/event.h"

#include <algorithm>
#include <cmath>

namespace kagero {

/// The parameter λ has reached Job::parameter_limit. The last step of a ray is shortened so that it ends at the limit.
struct ParameterLimit {
    static constexpr Effect effect = Effect::end;
    static constexpr Status status = Status::step_limit;

    template <class V>
    static bool exists(const Task<V>& task) {
        return std::isfinite(task.job.parameter_limit);
    }
    template <class V>
    KAGERO_INLINE static MaskOf<V> possible(const Task<V>& task, const Step<V>& step, const V&) {
        return crossed(task, step);
    }
    /// Returns the lanes whose λ has reached the limit, up to the rounding error of λ.
    template <class V>
    KAGERO_INLINE static MaskOf<V> crossed(const Task<V>& task, const Step<V>& step) {
        using S = ScalarOf<V>;
        return step.end.parameter >= V(S(task.job.parameter_limit) * (1 - 4 * machine_epsilon<S>));
    }
    template <class V>
    static MaskOf<V> starts_beyond(const Task<V>&, const RayState<V>&) {
        return no_lanes<V>();
    }
    /// Sets λ at the end of a step to the limit exactly.
    template <class V>
    static void finish(const Task<V>& task, Step<V>& step, std::uint64_t lanes) {
        step.end.parameter = select(from_bits<V>(lanes), V(ScalarOf<V>(task.job.parameter_limit)), step.end.parameter);
    }
    /// Returns the step length h, shortened to the remaining distance to the limit. A step that would leave a remainder
    /// below 1e-6 h is extended to the limit. The length 0 of an idle lane remains 0.
    template <class V>
    static V limited_length(const Task<V>& task, const RayState<V>& start, const V& h) {
        using S = ScalarOf<V>;
        const V remaining = V(S(task.job.parameter_limit)) - start.parameter;
        return select(remaining <= h * V(S(1 + 1e-6)), select(h > V(S(0)), remaining, h), h);
    }
};

/// A ray has taken Job::max_steps steps, or the greatest number of steps that its number type can count exactly.
struct StepLimit {
    static constexpr Effect effect = Effect::end;
    static constexpr Status status = Status::step_limit;

    template <class V>
    static bool exists(const Task<V>&) {
        return true;
    }
    template <class V>
    KAGERO_INLINE static MaskOf<V> possible(const Task<V>& task, const Step<V>&, const V& steps) {
        using S = ScalarOf<V>;
        return steps >= V(std::min(S(task.job.max_steps), max_exact_count<S>));
    }
    template <class V>
    static MaskOf<V> starts_beyond(const Task<V>&, const RayState<V>&) {
        return no_lanes<V>();
    }

    /// Greatest count up to which S represents every whole number exactly.
    template <class S>
    static constexpr S max_exact_count = S(2) / machine_epsilon<S>;
};

}  // namespace kagero
