/// Newton's method for the stages of a collocation step. It solves the few rays for which fixed-point iteration does
/// not converge. Each ray is solved separately in scalar arithmetic, so that the iterations of a ray do not depend on
/// its packet.
#pragma once

#include "kernels/numeric/linear_solve.h"
#include "kernels/integrators/implicit.h"
#include "kernels/integrators/shared.h"

#include <algorithm>

namespace kagero {

/// Solver for the stages of one ray: g_i = ∂K/∂(q, p) at start + h Σ_j a_ij (∂K/∂p, −∂K/∂q)_j. The initial guess of
/// every g_i is the gradient at the start. The Jacobian is the identity at h = 0, and its determinant stays positive
/// along the solution that is a continuous function of h. The solver fails if the determinant is not positive, or if a
/// correction is more than half of the previous correction (Deuflhard 2004, §2.1) and too large to be a rounding error.
/// Both tests prevent convergence to another solution.
template <class V, int N, class S = ScalarOf<V>>
class StageNewton {
public:
    StageNewton(const CalledSystem<V, N>& system, const State<S>& start, S h, const GaussNumbers<S>& w, int s,
                const Convergence<S>& convergence)
        : system_(system), start_(start), h_(h), w_(w), s_(s), convergence_(convergence) {
        system.ray_derivatives(start, g_[0]);
        for (int i = 1; i < s; ++i) std::copy(g_[0], g_[0] + phase_size, g_[i]);
    }
    /// Iterates until the stages converge. Returns false if they do not.
    bool solve() {
        constexpr int max_iterations = 12;
        S previous(0);
        while (iterations_ < max_iterations && convergence_.unconverged()) {
            linearise();
            if (!solve_linear(phase_size * s_, matrix_, residual_)) return false;  // determinant ≤ 0
            const S change = correct();
            if (iterations_++ > 0 && !(change <= S(0.5) * previous)) return convergence_.may_be_rounding(change);
            previous = change;
            convergence_.update_quadratic(change);
        }
        return !convergence_.unconverged();
    }
    int iterations() const { return iterations_; }
    /// Returns component k of the gradient at stage i.
    S stage(int i, int k) const { return g_[i][k]; }

private:
    /// Returns the row of the linear system for component k at stage i.
    static constexpr int row(int i, int k) { return phase_size * i + k; }
    /// Returns the state at stage i.
    State<S> stage_state(int i) const {
        State<S> y = start_;
        for (int j = 0; j < s_; ++j)
            for (int k = 0; k < space_size; ++k) {
                y.y[k] += h_ * w_.a[i][j] * g_[j][momentum(k)];
                y.y[momentum(k)] -= h_ * w_.a[i][j] * g_[j][k];
            }
        return y;
    }
    /// Sets up the linear system Σ_j (δ_ij I − h a_ij K'' M) Δ_j = ∂K/∂(q, p) − g_i for the corrections Δ. K'' is the
    /// Hessian of K at stage i, and M maps a gradient to (∂K/∂p, −∂K/∂q).
    void linearise() {
        for (int i = 0; i < s_; ++i) {
            const State<S> y = stage_state(i);
            PhaseGradient<S> fresh;
            Hessian<S> hessian;
            system_.ray_derivatives(y, fresh);
            system_.ray_hessian(y, hessian);
            for (int k = 0; k < phase_size; ++k) {
                residual_[row(i, k)] = fresh[k] - g_[i][k];
                for (int j = 0; j < s_; ++j)
                    for (int l = 0; l < phase_size; ++l) {
                        const S second = hessian[hessian_index(k, conjugate(l))];
                        const S entry = l < space_size ? -second : second;  // entry k, l of K'' M
                        matrix_[row(i, k)][row(j, l)] = S(i == j && k == l) - h_ * w_.a[i][j] * entry;
                    }
            }
        }
    }
    /// Adds the correction to the stages and returns its relative size. The linear solve has replaced the residual by
    /// the correction.
    S correct() {
        S change_q(0), change_p(0);
        for (int i = 0; i < s_; ++i)
            for (int k = 0; k < phase_size; ++k) {
                const S correction = residual_[row(i, k)];
                g_[i][k] += correction;
                S& greatest = k < space_size ? change_p : change_q;
                greatest = max(greatest, abs(correction));
            }
        return convergence_.relative(abs(h_) * change_q, abs(h_) * change_p);
    }

    const CalledSystem<V, N>& system_;
    State<S> start_;
    S h_;
    const GaussNumbers<S>& w_;
    int s_;
    Convergence<S> convergence_;
    int iterations_ = 0;
    PhaseGradient<S> g_[max_stages];
    S residual_[phase_size * max_stages], matrix_[phase_size * max_stages][phase_size * max_stages];
};

/// Solves the stages in the lanes outside `step.solved`, and adds the lanes that converge to `step.solved`.
template <class V, int N>
void SharedSolvers<V, N>::newton_stages(const CalledSystem<V, N>& system, StepperState<V, N>& step,
                                        const GaussNumbers<S>& w, int s, V* stages, int per_stage, int per_component) {
    std::uint64_t solved = 0;
    int max_iterations = 0;
    for (const int lane : lanes_in(to_bits(!step.solved))) {
        const auto in_lane = [lane](const V& value) { return get_lane(value, lane); };
        State<S> start;
        for (int k = 0; k < state_size; ++k) start.y[k] = in_lane(step.start.y[k]);
        const Vec3<V>& v = step.start.velocity;
        const Vec3<S> velocity{in_lane(v.x), in_lane(v.y), in_lane(v.z)};
        const S h = in_lane(step.h);
        StageNewton<V, N> newton(system, start, h, w, s, {start, h, velocity, step.options.solver_tolerance});
        const bool converged = newton.solve();
        set_lane(step.gradients, lane, in_lane(step.gradients) + S(2 * s * newton.iterations()));
        set_lane(step.lane_iterations, lane, in_lane(step.lane_iterations) + S(newton.iterations()));
        max_iterations = std::max(max_iterations, newton.iterations());
        if (!converged) continue;
        solved |= std::uint64_t(1) << lane;
        for (int i = 0; i < s; ++i)
            for (int k = 0; k < phase_size; ++k)
                set_lane(stages[i * per_stage + k * per_component], lane, newton.stage(i, k));
    }
    step.solved = step.solved | from_bits<V>(solved);
    step.issued_iterations += std::uint64_t(max_iterations);
}

}  // namespace kagero
