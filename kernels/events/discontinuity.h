/// A surface where H is not smooth: where the sign of its switching function changes, steps have to end, or every
/// method loses its order.
#pragma once

#include "kernels/events/event.h"

#include <cmath>

namespace kagero {

struct Discontinuity {
    static constexpr Effect effect = Effect::split;

    template <class V>
    static bool exists(const Task<V>& task) {
        return task.kernel.discontinuous;
    }
};

/// Lanes whose step has to end earlier, and its length until then.
template <class V>
struct SplitSteps {
    std::uint64_t lanes = 0;
    V length;
};

/// Finds the lengths of steps that end on the discontinuity. A lane that crosses it takes its step again, as often as
/// is needed until the step ends on it to rounding; a lane that only comes back to it within the step is shortened
/// once.
template <class V>
class DiscontinuitySearch {
    using S = ScalarOf<V>;

public:
    explicit DiscontinuitySearch(const Task<V>& task) : task_(task) {}

    /// Those of `moving` whose step crosses the discontinuity; in lanes of `first_tries` no step from this
    /// start has been repeated yet.
    ///
    /// A step that starts on the surface does not cross it there. The first new length follows from the parabola
    /// through the values of the switching function at the start, and along the tangent at half and at the whole step:
    /// for a ray that grazes a ball, the way inside goes with the root of its depth, and the end of a step may come
    /// from stages on the wrong side. The next ones follow from the secant through the last two tries.
    SplitSteps<V> split(const Step<V>& step, std::uint64_t moving, std::uint64_t first_tries) {
        const V on(S(16) * machine_epsilon<S>), zero(S(0)), one(S(1)), &a = step.start.switching,
                                                                       &end = step.end.switching;
        const MaskOf<V> starts_on = abs(a) <= on, leaves = abs(end) > on;
        const std::uint64_t across = moving & to_bits((a * end < zero) & (abs(a) > on) & leaves);
        const std::uint64_t same_side = moving & ~across & to_bits(leaves);
        SplitSteps<V> found;
        if (!(across | same_side)) return found;
        const V middle = value_ahead(step, V(S(0.5)) * step.h), beyond = value_ahead(step, step.h);
        const V c = V(S(2)) * (a + beyond - V(S(2)) * middle), b = beyond - a - c;
        const V square = b * b - V(S(4)) * a * c, root = sqrt(max(square, zero)),
                sum = b + select(b < zero, -root, root);
        const V first = V(S(-2)) * a / sum, least = select(starts_on, V(std::sqrt(machine_epsilon<S>)), zero);
        const V share = select((first > least) & (first < one), first, V(S(-0.5)) * sum / c);
        const MaskOf<V> has_zero = (square > zero) & (share > least) & (share < one);
        const MaskOf<V> comes_back = has_zero & (select(starts_on, -b, a) * beyond > zero);
        found.lanes = across | (same_side & first_tries & to_bits(comes_back));
        found.length = share * step.h;
        if (across) {
            const V first_length = select(has_zero, share, a / (a - end)) * step.h;
            found.length =
                select(from_bits<V>(across), next_length(step, across, first_tries, first_length), found.length);
        }
        return found;
    }

private:
    /// The switching function at a distance along the tangent at the start of the step.
    V value_ahead(const Step<V>& step, const V& length) const {
        State<V> there = step.start;
        there.set(advance(step.start.q(), length, step.start.velocity), step.start.p());
        return task_.kernel.switching_function(task_.system, there);
    }
    /// The zero of the secant through the last two tries. For a ray that grazes, the turning point may lie between
    /// them; where their secant leads out of the step, the chord does not.
    V next_length(const Step<V>& step, std::uint64_t lanes, std::uint64_t first_tries, const V& first) {
        const V secant = step.h - step.end.switching * (step.h - last_length_) / (step.end.switching - last_value_);
        const V chord = step.h * step.start.switching / (step.start.switching - step.end.switching);
        const V next =
            select(from_bits<V>(first_tries), first, select((secant > V(S(0))) & (secant < step.h), secant, chord));
        const MaskOf<V> here = from_bits<V>(lanes);
        last_length_ = select(here, step.h, last_length_), last_value_ = select(here, step.end.switching, last_value_);
        constexpr S shorter = S(0.98);  // than the last try, which ended beyond the surface
        return min(next, V(shorter) * step.h);
    }

    const Task<V>& task_;
    V last_length_ = S(0), last_value_ = S(0);  ///< of the last try of each lane
};

}  // namespace kagero
