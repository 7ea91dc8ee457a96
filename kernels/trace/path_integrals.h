/// Integrals along rays: the action ∫ p·dq, which is the optical path length in a medium, and the time ∫ ∂H/∂p_t dλ,
/// which is the coordinate time in a spacetime.
///
/// Steppers and their states do not contain these integrals. The tracing loop adds the part of every accepted step
/// where they are requested, so that other rays are traced by the same machine code. With time rescaling, p·∂K/∂p dτ =
/// p·∂H/∂p dλ and ∂K/∂p_t dτ = ∂H/∂p_t dλ on H = H0, because Ω depends on q alone. The integral over a step is a
/// quadrature:
///   Gauss methods    over the stages of the step, with the order of the method;
///   Runge–Kutta      over the stages of the method, which are evaluated again;
///   orbit methods    over eight partial steps to the nodes of the Gauss–Legendre formula in the orbit angle;
///   other methods    over the stages of a method of order eight, from the start of the step;
///   straight rays    the constant rates times the length of the step.
#pragma once

#include "kernels/trace/packet.h"

namespace kagero {

/// The integrals over one step: the action and the time.
template <class V>
using IntegralPair = V[2];

/// Computes the integrals over steps and parts of steps.
template <class V>
class PathIntegrals {
    using S = ScalarOf<V>;

public:
    explicit PathIntegrals(const Task<V>& task)
        : requested((task.job.outputs & output_integrals) != 0), task_(task),
          with_time_((task.job.outputs & output_time) && task.kernel.time_rate) {}

    const bool requested;  ///< True if the job requests an integral.

    /// Adds the integrals over a step that the stepper has just performed to `sums`, in the given lanes.
    __attribute__((noinline)) void add_step(const StepperState<V>& step, const MaskOf<V>& lanes,
                                            PathSums<V>& sums) const {
        IntegralPair<V> increment;
        over_step(step, increment);
        sums.add(increment, lanes);
    }
    /// Computes the integrals over a step that the stepper has just performed.
    void over_step(const StepperState<V>& step, IntegralPair<V>& out) const {
        out[0] = out[1] = V(S(0));
        if (task_.straight) add(step.h, step.start, step.start.velocity, out);
        else if (task_.method.info.angular) sum_over_angle(step, out);
        else if (task_.kernel.stage_state[task_.kind()]) sum_over_stages(step, out);
        else sum_over_runge_kutta(step, out);
    }
    /// Computes the integrals from the start of the step `whole` to the state `at` of an event on it, at about the step
    /// length `length`. The length is corrected until the step ends at the point of the event. The last correction is
    /// so short that the rates are constant over it.
    void up_to(const Step<V>& whole, const RayState<V>& at, V length, const MaskOf<V>& lanes,
               IntegralPair<V>& out) const {
        constexpr int max_corrections = 6;
        const V zero(S(0)), whole_length = abs(whole.h), farthest = V(S(0.25)) * whole_length,
                limit = V(S(0.25) * std::sqrt(machine_epsilon<S>)) * whole_length;
        for (int i = 0;; ++i) {
            const StepperState<V> part = partial_step(whole, select(lanes, length, zero));
            const Vec3<V> v = part.end.velocity;
            const V rest = dot(at.q() - part.end.q(), v) / dot(v, v);
            const V correction = select(lanes & is_finite(rest), max(min(rest, farthest), -farthest), zero);
            const MaskOf<V> open = abs(correction) > limit;
            if (i == max_corrections || !any(open)) {
                over_step(part, out);
                return add(correction, part.end, v, out);
            }
            length = select(open, length + correction, length);
        }
    }
    /// Returns the first part of the step `whole`, with the given length.
    StepperState<V> partial_step(const Step<V>& whole, const V& length) const {
        StepperState<V> part;
        static_cast<Step<V>&>(part) = whole;
        part.h = length;
        if (!task_.steps_without_begin) task_.begin(part);
        task_.step(part);
        // Some orbit methods limit a step to a multiple of its length, so that a limited step is shortened again.
        if (task_.method.info.angular && any(part.h < length)) {
            part.h = select(part.h < length, length * length / part.h, length);
            task_.step(part);
        }
        return part;
    }

private:
    /// Adds the rates at a state times `weight`, a length of the step. `velocity` is the derivative of q by the
    /// variable of the step: τ, or the orbit angle.
    void add(const V& weight, const State<V>& s, const Vec3<V>& velocity, IntegralPair<V>& out) const {
        out[0] = fma(weight, dot(s.p(), velocity), out[0]);
        if (!with_time_) return;
        V rate = task_.kernel.time_rate(task_.system, s);
        if (task_.method.info.angular && !task_.straight) {
            PhaseGradient<V> g;
            task_.kernel.gradient(task_.system, s, g);
            const Vec3<V> v = velocity_in(g);
            rate = rate * sqrt(dot(velocity, velocity) / dot(v, v));  // dλ/dφ times the rate by λ
        }
        out[1] = fma(weight, rate, out[1]);
    }
    void sum_over_stages(const StepperState<V>& step, IntegralPair<V>& out) const {
        const Coefficients& c = task_.method.coefficients;
        const GaussNumbers<S>& w = c.gauss->template numbers<S>();
        for (int i = 0; i < c.gauss->stages; ++i) {
            State<V> y;
            Vec3<V> velocity;
            task_.kernel.stage_state[task_.kind()](step, c, i, y, velocity);
            add(step.h * V(w.b[i]), y, velocity, out);
        }
    }
    void sum_over_angle(const StepperState<V>& step, IntegralPair<V>& out) const {
        const GaussNumbers<S>& w = gauss_tableau<max_stages>.template numbers<S>();
        for (int i = 0; i < max_stages; ++i) {
            S node(0);
            for (const S a : w.a[i]) node += a;
            const StepperState<V> part = partial_step(step, step.h * V(node));
            add(step.h * V(w.b[i]), part.end, part.end.velocity, out);
        }
    }
    void sum_over_runge_kutta(const StepperState<V>& step, IntegralPair<V>& out) const {
        const ButcherTable* const own = task_.method.coefficients.table;
        const ButcherTable& table = own ? *own : dormand_prince8;
        int stages = table.stages;
        while (table.b[stages - 1] == 0) --stages;  // stages of the error estimate
        PhaseGradient<V> g[max_rk_stages];
        for (int i = 0; i < stages; ++i) {
            State<V> y = step.start;
            for (int j = 0; j < i; ++j) {
                if (table.a[i][j] == 0) continue;
                const V w = step.h * V(S(table.a[i][j]));
                for (int k = 0; k < space_size; ++k) {
                    y.y[k] = fma(w, g[j][momentum(k)], y.y[k]);
                    y.y[momentum(k)] = fnma(w, g[j][k], y.y[momentum(k)]);
                }
            }
            task_.kernel.gradient(task_.system, y, g[i]);
            if (table.b[i] != 0) add(step.h * V(S(table.b[i])), y, velocity_in(g[i]), out);
        }
    }

    const Task<V>& task_;
    const bool with_time_;  ///< The job requests the time, and H depends on p_t.
};

}  // namespace kagero
