/// Newton's method for the stages of a collocation step, for rays that fixed-point iteration leaves unsolved. Few do,
/// and each is solved by itself, in scalar numbers, so that a ray needs the same iterations in every packet.
#pragma once

#include "kernels/numeric/linear_solve.h"
#include "kernels/integrators/implicit.h"
#include "kernels/integrators/shared.h"

#include <algorithm>

namespace kagero {

/// The stages of one ray: g = ∂K/∂(q, p) at start + h Σ_j a_ij (∂K/∂p, −∂K/∂q)_j, from the derivative at the start. The
/// Jacobian is the identity where h = 0; along the solution that grows out of the start its determinant stays positive.
/// That, and corrections that at least halve each time (Deuflhard 2004, §2.1), keep a second root away.
template <class V, int N, class S = ScalarOf<V>>
class StageNewton {
public:
    StageNewton(const CalledSystem<V, N>& system, const State<S>& start, S h, const GaussNumbers<S>& w, int s,
                const Convergence<S>& convergence)
        : system_(system), start_(start), h_(h), w_(w), s_(s), convergence_(convergence) {
        system.ray_derivatives(start, g_[0]);
        for (int i = 1; i < s; ++i) std::copy(g_[0], g_[0] + phase_size, g_[i]);
    }
    bool solve() {
        constexpr int max_iterations = 12;
        S last(0);
        while (iterations_ < max_iterations && convergence_.open()) {
            linearise();
            if (!solve_linear(phase_size * s_, matrix_, rest_)) return false;
            const S change = correct();
            if (iterations_++ > 0 && !(change <= S(0.5) * last)) return convergence_.is_rounding(change);
            last = change;
            convergence_.update_quadratic(change);
        }
        return !convergence_.open();
    }
    int iterations() const { return iterations_; }
    S stage(int i, int k) const { return g_[i][k]; }

private:
    /// The row of the linear system for component k at stage i.
    static constexpr int row(int i, int k) { return phase_size * i + k; }
    State<S> place(int i) const {
        State<S> y = start_;
        for (int j = 0; j < s_; ++j)
            for (int k = 0; k < space_size; ++k) {
                y.y[k] += h_ * w_.a[i][j] * g_[j][momentum(k)];
                y.y[momentum(k)] -= h_ * w_.a[i][j] * g_[j][k];
            }
        return y;
    }
    /// (I − h a_ij K'' M) Δ = ∂K − g, where M takes a gradient to (∂K/∂p, −∂K/∂q).
    void linearise() {
        for (int i = 0; i < s_; ++i) {
            const State<S> y = place(i);
            PhaseGradient<S> fresh;
            Hessian<S> second;
            system_.ray_derivatives(y, fresh);
            system_.ray_hessian(y, second);
            for (int k = 0; k < phase_size; ++k) {
                rest_[row(i, k)] = fresh[k] - g_[i][k];
                for (int j = 0; j < s_; ++j)
                    for (int l = 0; l < phase_size; ++l) {
                        const S paired = second[hessian_index(k, conjugate(l))];
                        const S moved = l < space_size ? -paired : paired;
                        matrix_[row(i, k)][row(j, l)] = S(i == j && k == l) - h_ * w_.a[i][j] * moved;
                    }
            }
        }
    }
    S correct() {
        S q(0), p(0);
        for (int i = 0; i < s_; ++i)
            for (int k = 0; k < phase_size; ++k) {
                const S correction = rest_[row(i, k)];
                g_[i][k] += correction;
                S& greatest = k < space_size ? p : q;
                greatest = max(greatest, abs(correction));
            }
        return convergence_.relative(abs(h_) * q, abs(h_) * p);
    }

    const CalledSystem<V, N>& system_;
    State<S> start_;
    S h_;
    const GaussNumbers<S>& w_;
    int s_;
    Convergence<S> convergence_;
    int iterations_ = 0;
    PhaseGradient<S> g_[max_stages];
    S rest_[phase_size * max_stages], matrix_[phase_size * max_stages][phase_size * max_stages];
};

/// Solves the stages of all rays that are not `f.solved`.
template <class V, int N>
void Shared<V, N>::newton_stages(const CalledSystem<V, N>& system, StepperState<V, N>& f, const GaussNumbers<S>& w,
                                 int s, V* stages, int per_stage, int per_component) {
    std::uint64_t solved = 0;
    int most = 0;
    for (const int lane : lanes_in(to_bits(!f.solved))) {
        const auto of = [lane](const V& v) { return get_lane(v, lane); };
        State<S> start;
        for (int k = 0; k < state_size; ++k) start.y[k] = of(f.start.y[k]);
        const Vec3<S> velocity{of(f.start.velocity.x), of(f.start.velocity.y), of(f.start.velocity.z)};
        StageNewton<V, N> newton(system, start, of(f.h), w, s, {start, of(f.h), velocity, f.options.solver_tolerance});
        const bool done = newton.solve();
        set_lane(f.gradients, lane, of(f.gradients) + S(2 * s * newton.iterations()));
        set_lane(f.open_iterations, lane, of(f.open_iterations) + S(newton.iterations()));
        most = std::max(most, newton.iterations());
        if (!done) continue;
        solved |= std::uint64_t(1) << lane;
        for (int i = 0; i < s; ++i)
            for (int k = 0; k < phase_size; ++k)
                set_lane(stages[i * per_stage + k * per_component], lane, newton.stage(i, k));
    }
    f.solved = f.solved | from_bits<V>(solved);
    f.issued_iterations += std::uint64_t(most);
}

}  // namespace kagero
