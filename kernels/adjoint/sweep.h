/// The reverse sweep along a ray. It integrates adjoints from the end of the ray to its start. An adjoint at a state of
/// the ray is the derivative of one of the two film coordinates of the ray end with respect to this state. The adjoints
/// give a bound on the effect of the rounding errors in all steps (Iri 1988; Satoh 2003, reference 11).
///
/// An adjoint a follows the transposed variational equation of the flow, da/dλ = −Aᵀa with A = J ∂²K/Ω. J is the
/// symplectic matrix, ∂²K is the Hessian, and Ω is 1 without time rescaling. For each step of the ray, one step of the
/// classical Runge–Kutta method integrates this equation. A cubic Hermite polynomial gives the ray state in the middle
/// of the step, at which A is evaluated.
///
/// The bound includes the rounding errors of each operation in the program of ∂K/∂(q, p), and of the sums that update
/// the state, whose number depends on the stepper. It includes neither the residual of implicit iterations nor the
/// rounding errors in a flow that a Hamiltonian defines in closed form.
#pragma once

#include "kernels/adjoint/rounding.h"
#include "kernels/integrators/implicit.h"
#include "kernels/methods/space_kernel.h"

namespace kagero {

/// The effect of a displacement of a ray on the two film coordinates of its end.
template <class V>
struct EndSensitivity {
    Vec3<V> normal;           ///< normal, of any length, of the surface on which the ray ends
    Vec3<V> by_position[2];   ///< derivatives of the film coordinates with respect to the position of the end
    Vec3<V> by_direction[2];  ///< derivatives of the film coordinates with respect to the unit direction at the end
};

/// The derivatives of the two film coordinates with respect to (q, p), one row per film coordinate.
template <class V>
using AdjointRows = PhaseGradient<V>[2];

/// The derivatives of K at one state, divided by Ω. On a ray, where H = H0, ∂K/∂(q, p) / Ω is the gradient of H.
template <class V>
struct FlowDerivatives {
    PhaseGradient<V> gradient;  ///< ∂K/∂(q, p) / Ω
    Hessian<V> hessian;         ///< ∂²K/∂(q, p)² / Ω
    V inverse_rescaling;        ///< 1/Ω
    V switching;  ///< switching function, which changes its sign at a discontinuity; unset if H has no discontinuity
    /// Returns dq/dλ.
    Vec3<V> velocity() const { return velocity_in(gradient); }
};

/// The system whose derivatives the sweep needs. Its functions are called through pointers, so that the sweep is
/// compiled once for all Hamiltonians. This is slower, but the sweep is rarely used.
template <class V>
struct SweptSystem {
    const SpaceKernel<V>& kernel;
    const SystemStorage& storage;
    ProgramWithUniforms<double> gradient_program = kernel.derivatives(storage);  ///< computes ∂K/∂(q, p)

    /// Returns a bound on the effect of the rounding errors in `gradient_program` at a state. `seeds` are the
    /// derivatives of the two film coordinates with respect to the outputs of this program.
    V rounding_bound(const State<V>& s, const AdjointRows<V>& seeds) const {
        return rounding_bound_of(gradient_program, s.y, &seeds[0][0], phase_size);
    }
};

/// The states that the sweep along a packet of rays has reached, and the adjoints at these states.
template <class V>
struct Sweep {
    State<V> state;
    FlowDerivatives<V> flow;  ///< derivatives at `state`; see detail::discontinuity_offset for a discontinuous H
    AdjointRows<V> rows;      ///< adjoints of the two film coordinates
    /// Bound on the effect of the rounding errors between `state` and the end of the ray. The unit of the bound is half
    /// a unit in the last place of 1.
    V bound;
};

namespace detail {

/// Steps may start or end on a discontinuity of H, where the derivatives have no value. If H has discontinuities, the
/// derivatives at the ends of a step are evaluated inside the step, at this fraction of its length from the ends.
inline constexpr double discontinuity_offset = 1e-6;

/// Returns the derivatives of K at a state.
template <class V>
FlowDerivatives<V> flow_derivatives_at(const SweptSystem<V>& system, const State<V>& state) {
    FlowDerivatives<V> flow;
    differentiate(system.gradient_program, state.y, flow.gradient, flow.hessian);
    flow.inverse_rescaling = recip(system.kernel.time_rescaling_factor(system.storage, state));
    for (V& g : flow.gradient) g = g * flow.inverse_rescaling;
    for (V& h : flow.hessian) h = h * flow.inverse_rescaling;
    if (system.kernel.discontinuous) flow.switching = system.kernel.switching_function(system.storage, state);
    return flow;
}

/// Returns a + s·(b − a).
template <class V>
State<V> between(const State<V>& a, const State<V>& b, double s) {
    State<V> result = a;
    for (int k = 0; k < phase_size; ++k) result.y[k] = fma(V(s), b.y[k] - a.y[k], a.y[k]);
    return result;
}

/// Returns the state in the middle of a step from a to b, by the cubic Hermite polynomial. `at_a` and `at_b` are the
/// derivatives at the two states, and `length` is the length of the step in λ.
template <class V>
State<V> middle_of(const State<V>& a, const FlowDerivatives<V>& at_a, const State<V>& b, const FlowDerivatives<V>& at_b,
                   const V& length) {
    State<V> middle = between(a, b, 0.5);
    const V eighth = V(0.125) * length;
    for (int k = 0; k < space_size; ++k) {
        middle.y[k] = fma(eighth, at_a.gradient[momentum(k)] - at_b.gradient[momentum(k)], middle.y[k]);
        middle.y[momentum(k)] = fnma(eighth, at_a.gradient[k] - at_b.gradient[k], middle.y[momentum(k)]);
    }
    return middle;
}

/// Writes Aᵀ·row to `out`. A = J ∂²K/Ω is the Jacobian matrix of Hamilton's equations, computed from the Hessian.
template <class V>
void multiply_by_transposed_jacobian(const Hessian<V>& hessian, const PhaseGradient<V>& row, PhaseGradient<V>& out) {
    for (int i = 0; i < phase_size; ++i) {
        out[i] = V(0.0);
        for (int k = 0; k < space_size; ++k)
            out[i] += hessian[hessian_index(i, momentum(k))] * row[k] -
                      hessian[hessian_index(i, k)] * row[momentum(k)];
    }
}

/// Integrates an adjoint, `row`, from the end of a step to its start by one Runge–Kutta step of the transposed
/// variational equation. `late`, `middle` and `early` are the derivatives at the end, in the middle and at the start.
template <class V>
void integrate_adjoint(const FlowDerivatives<V>& late, const FlowDerivatives<V>& middle,
                       const FlowDerivatives<V>& early, const V& length, PhaseGradient<V>& row) {
    PhaseGradient<V> rate[4];   // Aᵀa = −da/dλ at the four Runge–Kutta stages
    PhaseGradient<V> argument;  // the adjoint a at one stage
    const auto set_argument = [&](const V& h, const PhaseGradient<V>& previous_rate) {
        for (int i = 0; i < phase_size; ++i) argument[i] = fma(h, previous_rate[i], row[i]);
    };
    const V half = V(0.5) * length;
    multiply_by_transposed_jacobian(late.hessian, row, rate[0]);
    set_argument(half, rate[0]);
    multiply_by_transposed_jacobian(middle.hessian, argument, rate[1]);
    set_argument(half, rate[1]);
    multiply_by_transposed_jacobian(middle.hessian, argument, rate[2]);
    set_argument(length, rate[2]);
    multiply_by_transposed_jacobian(early.hessian, argument, rate[3]);
    for (int i = 0; i < phase_size; ++i)
        row[i] = fma(length * V(1 / 6.0), rate[0][i] + V(2.0) * (rate[1][i] + rate[2][i]) + rate[3][i], row[i]);
}

/// Transforms the adjoints across a surface where the gradient of K is discontinuous, by the transposed saltation
/// matrix. `before` and `after` are the derivatives on the two sides, in the order in which the ray crosses the
/// surface. Lanes whose switching function has the same sign on both sides are not changed. The jump of ∂K/∂q is
/// assumed to be normal to the surface.
template <class V>
void cross_discontinuity(const FlowDerivatives<V>& before, const FlowDerivatives<V>& after, AdjointRows<V>& rows) {
    const auto jump = [&](int k) { return after.gradient[k] - before.gradient[k]; };
    const MaskOf<V> crossed = before.switching * after.switching < V(0.0);
    const Vec3<V> force_jump{jump(component_x), jump(component_y), jump(component_z)};
    // Let f be `force_jump`, v the velocity, and row_p the momentum part of a row. The position part of the row changes
    // by −f (row_p·f)/(f·v).
    const V inverse_f_v = recip(dot(force_jump, before.velocity()));
    for (PhaseGradient<V>& row : rows) {
        const V factor = dot(velocity_in(row), force_jump) * inverse_f_v;
        for (int k = 0; k < space_size; ++k) row[k] = select(crossed, fnma(factor, jump(k), row[k]), row[k]);
    }
}

/// Returns a bound on the effect of one rounding error in each component of x: Σ_k |column k| · (unit in the first
/// place of x_k), where column k is (rows[0][k], rows[1][k]), and |·| is the Euclidean norm.
template <class V>
V rounding_effect(const AdjointRows<V>& rows, const V* x) {
    V sum(0.0);
    for (int k = 0; k < phase_size; ++k)
        sum += sqrt(rows[0][k] * rows[0][k] + rows[1][k] * rows[1][k]) * unit_in_first_place(x[k]);
    return sum;
}

/// Returns a bound on the effect of the rounding errors in a step. It includes those in the weighted sum of the stage
/// derivatives, in the states of the stages, and in the derivatives. It does not include the rounding of the state at
/// the end of the step, which `sweep_step` adds.
/// All terms are evaluated in the middle of the step; `middle` is the state there, and `flow` contains the derivatives.
template <class V>
V step_rounding_bound(const SweptSystem<V>& system, const State<V>& middle, const FlowDerivatives<V>& flow,
                      const V& length, const RoundingCounts& counts, const AdjointRows<V>& rows) {
    PhaseGradient<V> rates;  // dq/dλ and −dp/dλ
    // `seeds`: derivatives of the film coordinates with respect to ∂K/∂(q, p), if it changes equally in all stages.
    // `by_stages`: those with respect to the states of all stages, if they change equally, without the factor
    // weighted_length.
    AdjointRows<V> seeds, by_stages;
    const V weighted_length = V(counts.weight) * length;  // Σ|b|·length, with the weights b of the stages
    for (int r = 0; r < 2; ++r) {
        multiply_by_transposed_jacobian(flow.hessian, rows[r], by_stages[r]);
        for (int k = 0; k < space_size; ++k) {
            seeds[r][k] = -(weighted_length * flow.inverse_rescaling * rows[r][momentum(k)]);
            seeds[r][momentum(k)] = weighted_length * flow.inverse_rescaling * rows[r][k];
        }
    }
    for (int k = 0; k < space_size; ++k) {
        rates[k] = flow.gradient[momentum(k)];
        rates[momentum(k)] = flow.gradient[k];
    }
    const V sums_effect = V(counts.sums + 1) * rounding_effect(rows, rates);
    return abs(weighted_length) * (sums_effect + rounding_effect(by_stages, middle.y)) +
           system.rounding_bound(middle, seeds);
}

}  // namespace detail

/// Starts the sweep at the ends of the rays. `s.state` must contain the states at the ends.
template <class V>
void begin_sweep(const SweptSystem<V>& system, const EndSensitivity<V>& end, Sweep<V>& s) {
    using namespace detail;
    s.flow = flow_derivatives_at(system, s.state);
    const Vec3<V> velocity = s.flow.velocity();
    const V inverse_speed = rsqrt(dot(velocity, velocity));
    AdjointRows<V> seeds;  // derivatives of the film coordinates with respect to ∂K/∂(q, p)
    for (int r = 0; r < 2; ++r) {
        const Vec3<V> transverse = retreat(
            end.by_direction[r], dot(end.by_direction[r], velocity) * inverse_speed * inverse_speed, velocity);
        const V by_velocity[space_size] = {transverse.x * inverse_speed, transverse.y * inverse_speed,
                                           transverse.z * inverse_speed};
        const V by_position[space_size] = {end.by_position[r].x, end.by_position[r].y, end.by_position[r].z};
        for (int i = 0; i < phase_size; ++i) {
            s.rows[r][i] = i < space_size ? by_position[i] : V(0.0);
            for (int k = 0; k < space_size; ++k)
                s.rows[r][i] = fma(by_velocity[k], s.flow.hessian[hessian_index(momentum(k), i)], s.rows[r][i]);
            seeds[r][i] = i < space_size ? V(0.0) : by_velocity[conjugate(i)] * s.flow.inverse_rescaling;
        }
    }
    constexpr double refinement_roundings = 8;  // per component of the end state; an assumption
    s.bound = V(refinement_roundings) * rounding_effect(s.rows, s.state.y) + system.rounding_bound(s.state, seeds);
    // The end lies on the surface with the normal n. A displacement δq of the ray changes λ of the end by
    // −(n·δq)/(n·v), where v is the velocity. The film coordinates change by this change of λ times their derivatives
    // along the ray.
    const V inverse_normal_velocity = recip(dot(end.normal, velocity));
    const V normal[space_size] = {end.normal.x, end.normal.y, end.normal.z};
    for (PhaseGradient<V>& row : s.rows) {
        V along_ray(0.0);
        for (int k = 0; k < space_size; ++k)
            along_ray += row[k] * s.flow.gradient[momentum(k)] - row[momentum(k)] * s.flow.gradient[k];
        for (int k = 0; k < space_size; ++k) row[k] -= along_ray * inverse_normal_velocity * normal[k];
    }
}

/// Moves the sweep from the end of a step, `s.state`, to its start, `step_start`. `length` is the length of the step in
/// λ. In lanes with the length 0, the adjoints and the bound do not change.
template <class V>
void sweep_step(const SweptSystem<V>& system, const State<V>& step_start, const V& length, const RoundingCounts& counts,
                Sweep<V>& s) {
    using namespace detail;
    const bool discontinuous = system.kernel.discontinuous;
    FlowDerivatives<V> late = s.flow;
    if (discontinuous) {
        late = flow_derivatives_at(system, between(s.state, step_start, discontinuity_offset));
        cross_discontinuity(late, s.flow, s.rows);
    }
    const FlowDerivatives<V> early =
        flow_derivatives_at(system, discontinuous ? between(step_start, s.state, discontinuity_offset) : step_start);
    const State<V> middle = middle_of(step_start, early, s.state, late, length);
    const FlowDerivatives<V> middle_flow = flow_derivatives_at(system, middle);
    const V state_effect = V(counts.state) * rounding_effect(s.rows, s.state.y);
    AdjointRows<V> mean_rows;
    for (int r = 0; r < 2; ++r) {
        for (int i = 0; i < phase_size; ++i) mean_rows[r][i] = V(0.5) * s.rows[r][i];
        integrate_adjoint(late, middle_flow, early, length, s.rows[r]);
        for (int i = 0; i < phase_size; ++i) mean_rows[r][i] = fma(V(0.5), s.rows[r][i], mean_rows[r][i]);
    }
    const V step_effect = state_effect + step_rounding_bound(system, middle, middle_flow, length, counts, mean_rows);
    s.bound = select(abs(length) > V(0.0), s.bound + step_effect, s.bound);
    s.state = step_start;
    s.flow = early;
}

}  // namespace kagero
