/// Kinks: surfaces on which the derivatives of a formula jump, because a `min`, `max`, `abs` or `where` changes its
/// branch. Every method has a lower order in a step across a kink, and a derivative on the kink itself may be that of
/// the wrong side. A step therefore ends just before the kink, and the next one is so short that it passes the kink
/// without a visible error.
#pragma once

#include "kernels/events/event.h"

#include <cmath>

namespace kagero {

/// The steps of a packet near kinks.
template <class V>
struct KinkSteps {
    std::uint64_t shortened = 0;  ///< Lanes whose step crosses a kink; it must be repeated with `length`.
    std::uint64_t passing = 0;    ///< Lanes whose step is the short one that passes a kink.
    V length = ScalarOf<V>(0);
};

/// Finds the kinks on the steps of one packet. The switching function of a formula is zero on its kinks and of order
/// one elsewhere.
template <class V>
class KinkSearch {
    using S = ScalarOf<V>;

public:
    explicit KinkSearch(const Task<V>& task) : task_(task) {}

    /// Distance from a kink at which steps end before and behind it, as a value of the switching function.
    static constexpr S margin = std::is_same_v<S, float> ? S(1e-5) : S(1e-12);

    /// Returns the steps of `lanes` that cross a kink or pass it. The kink is searched on the dense output of the step.
    KinkSteps<V> find(const StepperState<V>& step, std::uint64_t lanes) {
        const V zero(S(0)), one(S(1)), &start = step.start.switching, &end = step.end.switching;
        KinkSteps<V> found;
        const MaskOf<V> is_close = abs(start) <= V(2 * margin);
        const Curve<V> curve = task_.curve(step);
        V before(zero), behind(one), value_before = start, value_behind = end;
        MaskOf<V> crossing = from_bits<V>(lanes) & (start * end < zero);
        // A step may cross the same kink twice, so a few points between its ends are tested too.
        for (const double s : {0.75, 0.5, 0.25}) {
            const V value = value_on(step, curve, V(S(s)));
            const MaskOf<V> crosses = from_bits<V>(lanes) & (start * value < zero);
            behind = select(crosses, V(S(s)), behind);
            value_behind = select(crosses, value, value_behind);
            crossing = crossing | crosses;
            const MaskOf<V> same_side = (start * value > zero) & (V(S(s)) < behind) & (V(S(s)) > before);
            before = select(same_side, V(S(s)), before);
            value_before = select(same_side, value, value_before);
        }
        if (!any(crossing)) return found;
        // Close to a kink and moving towards it: one short step, to the same distance behind the kink.
        const V rate = rate_at_start(step);
        const V pass_length = (abs(start) + V(margin)) / abs(rate);
        const MaskOf<V> approaching = crossing & is_close & (rate * start < zero);
        const MaskOf<V> is_short = abs(step.h) <= V(S(4)) * pass_length;
        found.passing = to_bits(approaching & is_short);
        // Otherwise: to a point before the kink, by the method of false position on the dense output (Illinois).
        const V target = select(start < zero, V(-margin), V(margin));
        value_before = value_before - target;
        value_behind = value_behind - target;
        for (int i = 0; i < 12; ++i) {
            const V s = before - value_before * (behind - before) / (value_behind - value_before);
            const V value = value_on(step, curve, s) - target;
            const MaskOf<V> is_before = value * start > zero, usable = is_finite(s) & is_finite(value);
            value_behind = select(usable & is_before, V(S(0.5)) * value_behind, value_behind);
            value_before = select(usable & !is_before, V(S(0.5)) * value_before, value_before);
            before = select(usable & is_before, s, before);
            value_before = select(usable & is_before, value, value_before);
            behind = select(usable & !is_before, s, behind);
            value_behind = select(usable & !is_before, value, value_behind);
        }
        found.length = select(approaching, pass_length, min(before, V(S(0.98))) * step.h);
        const MaskOf<V> can_shorten = found.length > zero;
        found.shortened = to_bits(crossing & can_shorten & !(approaching & is_short));
        return found;
    }

private:
    /// Returns the rate of change of the switching function along the tangent at the start of the step. The difference
    /// is taken over a length that is large compared with the rounding errors of the position.
    V rate_at_start(const StepperState<V>& step) const {
        const Vec3<V> q = step.start.q(), &v = step.start.velocity;
        const V size = max(max(abs(q.x), abs(q.y)), abs(q.z)), speed = max(max(abs(v.x), abs(v.y)), abs(v.z));
        const V length = max(V(S(1e-4)) * abs(step.h), V(S(std::sqrt(machine_epsilon<S>))) * size / speed);
        State<V> ahead = step.start;
        ahead.set(advance(step.start.q(), length, step.start.velocity), step.start.p());
        return (task_.kernel.switching_function(task_.system, ahead) - step.start.switching) / length;
    }
    /// Returns the switching function on the dense output at the fraction s of the step, where the momentum is
    /// interpolated linearly.
    V value_on(const StepperState<V>& step, const Curve<V>& curve, const V& s) const {
        State<V> state = step.start;
        Vec3<V> p = step.start.p();
        const Vec3<V> change = step.end.p() - p;
        p = advance(p, s, change);
        state.set(curve.at(s), p);
        return task_.kernel.switching_function(task_.system, state);
    }

    const Task<V>& task_;
};

}  // namespace kagero
