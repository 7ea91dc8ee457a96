/// The reverse sweep along a ray: how what is seen at its end moves with the state at every step, hence what the
/// roundings of all steps can do to it (Iri 1988; Satoh 2003, reference 11).
///
/// Adjoints go back by the transposed variational equation of the flow, da/dλ = −Aᵀa with A = J ∂²K/Ω, of which the
/// derivative programs yield the Hessians: by one classical Runge–Kutta step per step, its middle on the Hermite curve.
/// Roundings are those of the derivative programs, operation by operation, and of the sums that move the state, counted
/// by kind of step. Not counted: what an iteration leaves short of its solution, and what a closed form that a
/// Hamiltonian states rounds beside that.
#pragma once

#include "kernels/adjoint/rounding.h"
#include "kernels/integrators/implicit.h"
#include "kernels/methods/space_kernel.h"

namespace kagero {

/// What is seen at the ends of rays: two numbers, and how they move with the end and with the unit direction there.
template <class V>
struct Sight {
    Vec3<V> normal;  ///< of what rays end on
    Vec3<V> by_position[2], by_direction[2];
};

/// How these two numbers move with the state.
template <class V>
using Rows = PhaseGradient<V>[2];

/// The flow of H at one place, K being Ω(H − H0).
template <class V>
struct SweptPlace {
    PhaseGradient<V> slope;     ///< ∂K/Ω
    Hessian<V> curvature;  ///< ∂²K/Ω
    V inverse_rescaling;        ///< 1/Ω
    V switching;                ///< changes sign where H is not smooth
    Vec3<V> velocity() const { return velocity_in(slope); }
};

/// A system as the sweep sees it: through pointers, because few ask for it.
template <class V>
struct SweptSystem {
    const SpaceKernel<V>& kernel;
    const SystemStorage& storage;
    Listed<double> derivatives = kernel.derivatives(storage);

    V roundings(const State<V>& s, const Rows<V>& seeds) const {
        return sum_of_roundings(derivatives, s.y, &seeds[0][0], phase_size);
    }
};

/// Rays on their way back.
template <class V>
struct Sweep {
    State<V> state;
    SweptPlace<V> place;  ///< at the state; where H is not smooth, just after it
    Rows<V> rows;
    V bound;         ///< of how far roundings move the two numbers, in units of half the last place of 1
};

namespace detail {

/// Where H is not smooth a slope is looked at beside the state, by this share of the step.
inline constexpr double aside = 1e-6;

template <class V>
SweptPlace<V> place_at(const SweptSystem<V>& system, const State<V>& state) {
    SweptPlace<V> place;
    differentiate(system.derivatives, state.y, place.slope, place.curvature);
    place.inverse_rescaling = recip(system.kernel.time_rescaling_factor(system.storage, state));
    for (V& s : place.slope) s = s * place.inverse_rescaling;
    for (V& c : place.curvature) c = c * place.inverse_rescaling;
    if (system.kernel.discontinuous) place.switching = system.kernel.switching_function(system.storage, state);
    return place;
}

/// a + s·(b − a).
template <class V>
State<V> between(const State<V>& a, const State<V>& b, double s) {
    State<V> y = a;
    for (int k = 0; k < phase_size; ++k) y.y[k] = fma(V(s), b.y[k] - a.y[k], a.y[k]);
    return y;
}

/// The middle of a step on the Hermite curve.
template <class V>
State<V> middle_of(const State<V>& a, const SweptPlace<V>& at_a, const State<V>& b, const SweptPlace<V>& at_b,
                   const V& length) {
    State<V> y = between(a, b, 0.5);
    const V eighth = V(0.125) * length;
    for (int k = 0; k < space_size; ++k) {
        y.y[k] = fma(eighth, at_a.slope[momentum(k)] - at_b.slope[momentum(k)], y.y[k]);
        y.y[momentum(k)] = fnma(eighth, at_a.slope[k] - at_b.slope[k], y.y[momentum(k)]);
    }
    return y;
}

/// Aᵀ row.
template <class V>
void transposed(const Hessian<V>& curvature, const PhaseGradient<V>& row, PhaseGradient<V>& out) {
    for (int i = 0; i < phase_size; ++i) {
        out[i] = V(0.0);
        for (int k = 0; k < space_size; ++k)
            out[i] += curvature[hessian_index(i, momentum(k))] * row[k] -
                      curvature[hessian_index(i, k)] * row[momentum(k)];
    }
}

/// A step of the transposed variational equation, back from `late` to `early`.
template <class V>
void carry_back(const SweptPlace<V>& late, const SweptPlace<V>& middle, const SweptPlace<V>& early, const V& length,
                PhaseGradient<V>& row) {
    PhaseGradient<V> slope[4], at;
    const auto moved = [&](const V& by, const PhaseGradient<V>& along) {
        for (int i = 0; i < phase_size; ++i) at[i] = fma(by, along[i], row[i]);
    };
    const V half = V(0.5) * length;
    transposed(late.curvature, row, slope[0]);
    moved(half, slope[0]), transposed(middle.curvature, at, slope[1]);
    moved(half, slope[1]), transposed(middle.curvature, at, slope[2]);
    moved(length, slope[2]), transposed(early.curvature, at, slope[3]);
    for (int i = 0; i < phase_size; ++i)
        row[i] = fma(length * V(1 / 6.0), slope[0][i] + V(2.0) * (slope[1][i] + slope[2][i]) + slope[3][i], row[i]);
}

/// Back through a surface where the slope of K jumps, across itself, from `before` to `after`.
template <class V>
void carry_through(const SweptPlace<V>& before, const SweptPlace<V>& after, Rows<V>& rows) {
    const auto jump = [&](int k) { return after.slope[k] - before.slope[k]; };
    const MaskOf<V> crossed = before.switching * after.switching < V(0.0);
    const Vec3<V> force_jump{jump(component_x), jump(component_y), jump(component_z)};
    const V inverse = recip(dot(force_jump, before.velocity()));
    for (PhaseGradient<V>& row : rows) {
        const V kick = dot(velocity_in(row), force_jump) * inverse;
        for (int k = 0; k < space_size; ++k) row[k] = select(crossed, fnma(kick, jump(k), row[k]), row[k]);
    }
}

/// Σ |row_k · last place of x_k|, of both rows together.
template <class V>
V reach(const Rows<V>& rows, const V* x) {
    V sum(0.0);
    for (int k = 0; k < phase_size; ++k)
        sum += sqrt(rows[0][k] * rows[0][k] + rows[1][k] * rows[1][k]) * first_place(x[k]);
    return sum;
}

/// What the roundings of a step do, beside those of the state at its end: in the sums that move it, in the places of
/// the stages, and in the derivatives, looked at in the middle.
template <class V>
V roundings_of(const SweptSystem<V>& system, const State<V>& middle, const SweptPlace<V>& place, const V& length,
               const RoundingCounts& counts, const Rows<V>& rows) {
    PhaseGradient<V> flow;
    Rows<V> seeds, by_stages;
    const V share = V(counts.weight) * length;
    for (int r = 0; r < 2; ++r) {
        transposed(place.curvature, rows[r], by_stages[r]);
        for (int k = 0; k < space_size; ++k) {
            seeds[r][k] = -(share * place.inverse_rescaling * rows[r][momentum(k)]);
            seeds[r][momentum(k)] = share * place.inverse_rescaling * rows[r][k];
        }
    }
    for (int k = 0; k < space_size; ++k) flow[k] = place.slope[momentum(k)], flow[momentum(k)] = place.slope[k];
    return abs(share) * (V(counts.sums + 1) * reach(rows, flow) + reach(by_stages, middle.y)) +
           system.roundings(middle, seeds);
}

}  // namespace detail

/// Where rays end.
template <class V>
void begin_sweep(const SweptSystem<V>& system, const Sight<V>& view, Sweep<V>& s) {
    using namespace detail;
    s.place = place_at(system, s.state);
    const Vec3<V> velocity = s.place.velocity();
    const V inverse = rsqrt(dot(velocity, velocity));
    Rows<V> seeds;
    for (int r = 0; r < 2; ++r) {
        const Vec3<V> turn =
            retreat(view.by_direction[r], dot(view.by_direction[r], velocity) * inverse * inverse, velocity);
        const V by_velocity[space_size] = {turn.x * inverse, turn.y * inverse, turn.z * inverse};
        const V by_position[space_size] = {view.by_position[r].x, view.by_position[r].y, view.by_position[r].z};
        for (int i = 0; i < phase_size; ++i) {
            s.rows[r][i] = i < space_size ? by_position[i] : V(0.0);
            for (int k = 0; k < space_size; ++k)
                s.rows[r][i] = fma(by_velocity[k], s.place.curvature[hessian_index(momentum(k), i)], s.rows[r][i]);
            seeds[r][i] = i < space_size ? V(0.0) : by_velocity[conjugate(i)] * s.place.inverse_rescaling;
        }
    }
    constexpr double while_found = 8;  // the end is rounded a few times while it is found, along the ray as well
    s.bound = V(while_found) * reach(s.rows, s.state.y) + system.roundings(s.state, seeds);
    // A ray that is late or early ends on the same surface.
    const V across = recip(dot(view.normal, velocity));
    const V normal[space_size] = {view.normal.x, view.normal.y, view.normal.z};
    for (PhaseGradient<V>& row : s.rows) {
        V late(0.0);
        for (int k = 0; k < space_size; ++k)
            late += row[k] * s.place.slope[momentum(k)] - row[momentum(k)] * s.place.slope[k];
        for (int k = 0; k < space_size; ++k) row[k] -= late * across * normal[k];
    }
}

/// Back by a step of `length` in λ; nothing where that is 0.
template <class V>
void sweep_step(const SweptSystem<V>& system, const State<V>& from, const V& length, const RoundingCounts& counts,
                Sweep<V>& s) {
    using namespace detail;
    const bool discontinuous = system.kernel.discontinuous;
    SweptPlace<V> late = s.place;
    if (discontinuous) {
        late = place_at(system, between(s.state, from, aside));
        carry_through(late, s.place, s.rows);
    }
    const SweptPlace<V> early = place_at(system, discontinuous ? between(from, s.state, aside) : from);
    const State<V> middle = middle_of(from, early, s.state, late, length);
    const SweptPlace<V> between_them = place_at(system, middle);
    const V of_state = V(counts.state) * reach(s.rows, s.state.y);
    Rows<V> rows_there;
    for (int r = 0; r < 2; ++r) {
        for (int i = 0; i < phase_size; ++i) rows_there[r][i] = V(0.5) * s.rows[r][i];
        carry_back(late, between_them, early, length, s.rows[r]);
        for (int i = 0; i < phase_size; ++i) rows_there[r][i] = fma(V(0.5), s.rows[r][i], rows_there[r][i]);
    }
    const V of_step = of_state + roundings_of(system, middle, between_them, length, counts, rows_there);
    s.bound = select(abs(length) > V(0.0), s.bound + of_step, s.bound);
    s.state = from, s.place = early;
}

}  // namespace kagero
