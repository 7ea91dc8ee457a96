/// Extrapolation of rays from the end of a step to a surface that is very close, and the rounding error of a position.
#pragma once

#include "kernels/integrators/stepper_state.h"
#include "kernels/intersection/surface.h"

namespace kagero {

/// Extrapolates rays by a small parameter length beyond the last step, onto their surfaces. Positions are extrapolated
/// with the velocity at the end and its mean rate of change in the step. Other quantities are extrapolated with their
/// mean rates in the step, by at most one step length, because a longer one would magnify rounding errors. Other
/// lanes keep their values, because their steps may have ended at states that are not finite.
template <class V>
void extrapolate(const StepperState<V>& step, const LevelSet<V>& level_set, const V& length, const MaskOf<V>& lanes,
                 StepEnd<V>& refined) {
    using S = ScalarOf<V>;
    const V one(S(1)), zero(S(0)), h = select(lanes, length, zero);
    const V ratio = select(lanes & (abs(step.h) > zero), max(min(h / step.h, one), -one), zero);
    const Vec3<V> velocity = advance(step.end.velocity, V(S(0.5)) * ratio, step.end.velocity - step.start.velocity);
    const Vec3<V> q = advance(refined.end.q(), h, velocity);
    const V offset = level_set.value(q) / level_set.slope(q, step.end.velocity),
            h_to_surface = select(lanes & is_finite(offset), h - offset, h);
    const auto extrapolate_value = [&](const V& from, const V& to, V& end) {
        end = select(lanes, fma(ratio, to - from, end), end);
    };
    const Vec3<V> last = refined.end.q();
    refined.end.set(select<V>(lanes, advance(last, h_to_surface, velocity), last), refined.end.p());
    for (int k = 0; k < space_size; ++k)
        extrapolate_value(step.start.y[momentum(k)], step.end.y[momentum(k)], refined.end.y[momentum(k)]);
    extrapolate_value(step.start.velocity.x, step.end.velocity.x, refined.end.velocity.x);
    extrapolate_value(step.start.velocity.y, step.end.velocity.y, refined.end.velocity.y);
    extrapolate_value(step.start.velocity.z, step.end.velocity.z, refined.end.velocity.z);
    extrapolate_value(step.start.parameter, step.end.parameter, refined.end.parameter);
}

/// Returns a number that is finite if the momentum is finite.
template <class V>
V sum_of_momenta(const State<V>& state) {
    const Vec3<V> p = state.p();
    return p.x + p.y + p.z;
}

/// Returns the rounding error of the position q, as a fraction of the step.
template <class V>
V position_rounding(const Step<V>& step, const Vec3<V>& q, const V& full_length) {
    using S = ScalarOf<V>;
    const Vec3<V>& v = step.start.velocity;
    const V rounding = V(machine_epsilon<S>) * greatest_component(q) / (greatest_component(v) * abs(full_length));
    return select(is_finite(rounding), rounding, V(S(0)));
}

}  // namespace kagero
