/// Discontinuities: surfaces on which H is not smooth. The switching function of H changes its sign on them. A step
/// must end on such a surface, because every method has a lower order in a step across the surface.
#pragma once

#include "kernels/events/event.h"

#include <cmath>

namespace kagero {

/// The discontinuity as an event. DiscontinuitySearch detects it; EventDetector does not test for it.
struct Discontinuity {
    static constexpr Effect effect = Effect::split;

    template <class V>
    static bool exists(const Task<V>& task) {
        return task.kernel.discontinuous;
    }
};

/// Lanes whose step has to be repeated with a shorter length, and that length.
template <class V>
struct SplitSteps {
    std::uint64_t lanes = 0;
    V length;
};

/// Finds the lengths of steps that end on the discontinuity. The step of a lane that crosses the surface is repeated
/// until it ends on the surface, except for rounding. A step that crosses the surface twice is shortened only once.
template <class V>
class DiscontinuitySearch {
    using S = ScalarOf<V>;

public:
    explicit DiscontinuitySearch(const Task<V>& task) : task_(task) {}

    /// Returns the lanes of `moving` whose step crosses the discontinuity, with new step lengths. In the lanes of
    /// `first_tries`, no step from this start has been repeated yet.
    ///
    /// If a step starts on the surface, this zero of the switching function does not count. The first new length is a
    /// zero of the parabola through three values of the switching function: at the start, and at half and full length
    /// along the tangent. A secant would not suffice: the length of a ray inside a ball that it grazes is proportional
    /// to the square root of the depth. Values on the tangent are used because the end of the step may depend on stages
    /// beyond the surface. Later lengths follow from the secant through the last two tries.
    SplitSteps<V> split(const Step<V>& step, std::uint64_t moving, std::uint64_t first_tries) {
        const V rounding(S(16) * machine_epsilon<S>), zero(S(0)), one(S(1));
        const V &a = step.start.switching, &end = step.end.switching;
        const MaskOf<V> starts_on_surface = abs(a) <= rounding, ends_off_surface = abs(end) > rounding;
        const std::uint64_t crossing = moving & to_bits((a * end < zero) & (abs(a) > rounding) & ends_off_surface);
        const std::uint64_t may_cross_twice = moving & ~crossing & to_bits(ends_off_surface);
        SplitSteps<V> found;
        if (!(crossing | may_cross_twice)) return found;
        const V middle = value_ahead(step, V(S(0.5)) * step.h), beyond = value_ahead(step, step.h);
        // The parabola a + b·s + c·s² interpolates the three values; s is the fraction of the step. Its zeros are
        // −2a / sum and −sum / 2c, which avoids cancellation.
        const V c = V(S(2)) * (a + beyond - V(S(2)) * middle), b = beyond - a - c;
        const V square = b * b - V(S(4)) * a * c, root = sqrt(max(square, zero)),
                sum = b + select(b < zero, -root, root);
        const V root_fraction = V(S(-2)) * a / sum;
        const V least = select(starts_on_surface, V(std::sqrt(machine_epsilon<S>)), zero);
        const V fraction = select((root_fraction > least) & (root_fraction < one), root_fraction, V(S(-0.5)) * sum / c);
        const MaskOf<V> has_zero = (square > zero) & (fraction > least) & (fraction < one);
        const MaskOf<V> crosses_and_returns = has_zero & (select(starts_on_surface, -b, a) * beyond > zero);
        found.lanes = crossing | (may_cross_twice & first_tries & to_bits(crosses_and_returns));
        found.length = fraction * step.h;
        if (crossing) {
            const V first_length = select(has_zero, fraction, a / (a - end)) * step.h;
            const V next_length = next_try_length(step, crossing, first_tries, first_length);
            found.length = select(from_bits<V>(crossing), next_length, found.length);
        }
        return found;
    }

private:
    /// Returns the switching function at the position q + length·dq/dτ on the tangent at the start of the step.
    V value_ahead(const Step<V>& step, const V& length) const {
        State<V> state = step.start;
        state.set(advance(step.start.q(), length, step.start.velocity), step.start.p());
        return task_.kernel.switching_function(task_.system, state);
    }
    /// Returns the next length of a step across the surface: `first_length` in lanes of `first_tries`, else the zero of
    /// the secant through the last two tries. For a grazing ray, an extremum of the switching function may lie between
    /// the two tries, and the zero of the secant outside the step. Then the switching function is interpolated linearly
    /// between the start and the end of the step instead.
    V next_try_length(const Step<V>& step, std::uint64_t lanes, std::uint64_t first_tries, const V& first_length) {
        const V secant_zero =
            step.h - step.end.switching * (step.h - last_try_length_) / (step.end.switching - last_try_value_);
        const V linear_zero = step.h * step.start.switching / (step.start.switching - step.end.switching);
        const V later_length = select((secant_zero > V(S(0))) & (secant_zero < step.h), secant_zero, linear_zero);
        const V next = select(from_bits<V>(first_tries), first_length, later_length);
        const MaskOf<V> mask = from_bits<V>(lanes);
        last_try_length_ = select(mask, step.h, last_try_length_);
        last_try_value_ = select(mask, step.end.switching, last_try_value_);
        constexpr S shorter = S(0.98);  // The last try ended beyond the surface, so the next one must be shorter.
        return min(next, V(shorter) * step.h);
    }

    const Task<V>& task_;
    /// Length of the last try in each lane, and the switching function at its end.
    V last_try_length_ = S(0), last_try_value_ = S(0);
};

}  // namespace kagero
