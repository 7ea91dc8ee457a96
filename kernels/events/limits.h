/// The limits of a job: the parameter λ and the number of steps. Both lie at the end of a step.
#pragma once

#include "kernels/events/event.h"

#include <algorithm>
#include <cmath>

namespace kagero {

/// λ reaches Job::parameter_limit. Steps are shortened so that one of them ends there.
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
    template <class V>
    KAGERO_INLINE static MaskOf<V> crossed(const Task<V>& task, const Step<V>& step) {
        using S = ScalarOf<V>;
        return step.end.parameter >= V(S(task.job.parameter_limit) * (1 - 4 * machine_epsilon<S>));
    }
    template <class V>
    static MaskOf<V> starts_beyond(const Task<V>&, const RayState<V>&) {
        return never<V>();
    }
    /// Removes the rounding of a step that ends at the limit.
    template <class V>
    static void finish(const Task<V>& task, Step<V>& step, std::uint64_t lanes) {
        step.end.parameter = select(from_bits<V>(lanes), V(ScalarOf<V>(task.job.parameter_limit)), step.end.parameter);
    }
    /// The longest step from `start` is h, or what is left of λ; a last step that is very short becomes a part of the
    /// one before it.
    template <class V>
    static V bounded(const Task<V>& task, const RayState<V>& start, const V& h) {
        using S = ScalarOf<V>;
        const V left = V(S(task.job.parameter_limit)) - start.parameter;
        return select(left <= h * V(S(1 + 1e-6)), select(h > V(S(0)), left, h), h);
    }
};

/// A ray has taken Job::max_steps steps, or as many as its number type can count.
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
        return steps >= V(std::min(S(task.job.max_steps), most_counted<S>));
    }
    template <class V>
    static MaskOf<V> starts_beyond(const Task<V>&, const RayState<V>&) {
        return never<V>();
    }

    /// Beyond this number S cannot represent every whole number.
    template <class S>
    static constexpr S most_counted = S(2) / machine_epsilon<S>;
};

}  // namespace kagero
