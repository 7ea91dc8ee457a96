/// Gauss–Legendre collocation of one ray with its stages in the lanes (as in IRKGL16-SIMD, arXiv 2511.03655). This is
/// the form `stages` of the strategy `per-ray`. In an iteration, the stages are independent evaluations of one program.
///
/// The iteration and the order of its operations are the same as in the stepper `Gauss`, so that the states are equal.
#pragma once

#include "kernels/comparison/forward.h"
#include "kernels/integrators/gauss.h"

namespace kagero {

/// The matrices `a` and `extrapolation` of a Gauss method (GaussNumbers), column by column. Element i of a column
/// belongs to stage i; elements beyond the number of stages repeat the last stage.
template <class S>
struct StageColumns {
    alignas(64) S a[max_stages][max_stages], extrapolation[max_stages][max_stages];
};

namespace detail {

/// Returns the columns of the Gauss method with s stages.
template <class S, int s>
constexpr StageColumns<S> make_stage_columns() {
    StageColumns<S> columns{};
    const GaussNumbers<S>& rows = gauss_tableau<s>.template numbers<S>();
    for (int j = 0; j < s; ++j)
        for (int i = 0; i < max_stages; ++i) {
            const int stage = i < s ? i : s - 1;
            columns.a[j][i] = rows.a[stage][j];
            columns.extrapolation[j][i] = rows.extrapolation[stage][j];
        }
    return columns;
}
/// The columns of the Gauss methods with 1 to 8 stages. They are not constexpr, because g++ 12 may replace 64 bytes of
/// a constant table by zeros.
template <class S>
inline constinit StageColumns<S> stage_columns[] = {make_stage_columns<S, 1>(), make_stage_columns<S, 2>(),
                                                    make_stage_columns<S, 3>(), make_stage_columns<S, 4>(),
                                                    make_stage_columns<S, 5>(), make_stage_columns<S, 6>(),
                                                    make_stage_columns<S, 7>(), make_stage_columns<S, 8>()};

/// Loads a vector from aligned memory, register by register. If the vector were copied as a whole, g++ would use stores
/// that are smaller than a register. A later load of a register would then stall, because several stores cannot be
/// forwarded to one load.
template <class L, class S>
KAGERO_INLINE L load(const S* from) {
    L l;
    for (int r = 0; r < ValueTraits<L>::registers; ++r)
        l.v[r] = *reinterpret_cast<const typename L::Register*>(from + r * L::width);
    return l;
}
/// Stores the lanes of `l` in aligned memory, register by register.
template <class L, class S>
KAGERO_INLINE void store(const L& l, S* to) {
    for (int r = 0; r < ValueTraits<L>::registers; ++r)
        *reinterpret_cast<typename L::Register*>(to + r * L::width) = l.v[r];
}

/// Calls f(k) for each component k of a gradient. The loop is unrolled by hand, because g++ would not unroll it and
/// would keep the gradient in memory.
template <class Function>
KAGERO_INLINE void for_each_component(const Function& f) {
    f(component_x);
    f(component_y);
    f(component_z);
    f(component_px);
    f(component_py);
    f(component_pz);
}

/// Returns the greatest of the numbers in the lanes.
template <class L>
KAGERO_INLINE ScalarOf<L> greatest_lane(const L& l) {
    constexpr int lanes = lane_count<L>;
    alignas(64) ScalarOf<L> x[lanes];
    store(l, x);
    for (int half = lanes / 2; half > 0; half /= 2)
        for (int i = 0; i < half; ++i) x[i] = max(x[i], x[i + half]);
    return x[0];
}

}  // namespace detail

/// Stepper of Gauss methods with stages in the lanes. `fixed_stages` is the number of stages, a compile-time constant.
/// If it is 0, the number of stages is read from the coefficients.
template <int fixed_stages>
struct StagesInLanes {
    static constexpr bool stages_inside = true;  // no stage lies at an end of the step
    template <class System>
    static constexpr const char* refusal() { return nullptr; }

    /// Sets the gradients at all stages to the gradient at the start, as the initial guess of the first step.
    template <class System, class S, int N>
    static void begin(const System& system, StepperState<S, N>& step, const Coefficients&) {
        PhaseGradient<S> g;
        system.derivatives(step.start, g);
        for (int k = 0; k < phase_size; ++k)
            for (int i = 0; i < max_stages; ++i) row(stage_memory(step), k)[i] = g[k];
    }

    template <class System, class S, int N>
    static void step(const System& system, StepperState<S, N>& step, const Coefficients& coefficients) {
        constexpr int width = Lanes<S, 1>::width;
        if constexpr (fixed_stages > 0 || width >= max_stages) {
            constexpr int most_stages = fixed_stages ? fixed_stages : max_stages;
            step_with_registers<detail::registers_for<S, most_stages>>(system, step, coefficients);
        } else {
            const int s = stages(coefficients);
            if (s <= width) return step_with_registers<1>(system, step, coefficients);
            if (s <= 2 * width) return step_with_registers<2>(system, step, coefficients);
            if constexpr (2 * width < max_stages) step_with_registers<4>(system, step, coefficients);
        }
    }

    /// Returns the dense output of a step.
    template <class S, int N = default_carried>
    static Curve<S> curve(const StepperState<S, N>& step, const Coefficients& coefficients) {
        const S* g = stage_memory(step);
        const auto velocity = [g](int j) {
            return Vec3<S>{row(g, component_px)[j], row(g, component_py)[j], row(g, component_pz)[j]};
        };
        return Curve<S>::collocation(step, coefficients.gauss->template numbers<S>(), stages(coefficients), velocity);
    }
    /// Writes the state and dq/dτ at stage i of the last step.
    template <class S, int N = default_carried>
    static void stage_state(const StepperState<S, N>& step, const Coefficients& coefficients, int i, State<S>& y,
                            Vec3<S>& velocity) {
        const S *g = stage_memory(step), *weights = coefficients.gauss->template numbers<S>().a[i];
        for (int k = 0; k < phase_size; ++k) {
            S total(0);
            for (int j = 0; j < stages(coefficients); ++j) total = fma(weights[j], row(g, conjugate(k))[j], total);
            y.y[k] = k < space_size ? fma(step.h, total, step.start.y[k]) : fnma(step.h, total, step.start.y[k]);
        }
        y.pt() = step.start.pt();
        velocity = {row(g, component_px)[i], row(g, component_py)[i], row(g, component_pz)[i]};
    }

private:
    static constexpr int stages(const Coefficients& coefficients) {
        return fixed_stages ? fixed_stages : coefficients.gauss->stages;
    }
    /// Returns StepperState::stage as an array of numbers: element max_stages·k + i is component k of the gradient at
    /// stage i.
    template <class AnyState>
    KAGERO_INLINE static auto* stage_memory(AnyState& step) {
        static_assert(sizeof step.stage == sizeof step.h * phase_size * max_stages);
        return &step.stage[0][0];
    }

    /// Returns component k of the gradient at all stages, as an array of `max_stages` numbers in g.
    template <class T>
    KAGERO_INLINE static T* row(T* g, int k) { return g + k * max_stages; }

    /// Returns Σ_j columns[j]·g[j] over the s stages; lane i of the result belongs to stage i. g is an array in memory,
    /// so that one instruction loads and broadcasts g[j].
    template <class L, class S>
    KAGERO_INLINE static L sum(const S* g, const S (&columns)[max_stages][max_stages], int s) {
        L total = detail::load<L>(columns[0]) * L(g[0]);
        for (int j = 1; j < s; ++j) total = fma(detail::load<L>(columns[j]), L(g[j]), total);
        return total;
    }
    /// Writes the states at all s stages to y, one stage per lane. g contains the gradients at the stages.
    template <class L, class S, int N>
    KAGERO_INLINE static void stage_states(const StepperState<S, N>& step, const S* g, const StageColumns<S>& columns,
                                           int s, State<L>& y) {
        detail::for_each_component([&](int k) __attribute__((always_inline)) {
            if (k < space_size) y.y[k] = fma(L(step.h), sum<L>(row(g, conjugate(k)), columns.a, s), L(step.start.y[k]));
            else y.y[k] = fnma(L(step.h), sum<L>(row(g, conjugate(k)), columns.a, s), L(step.start.y[k]));
        });
        y.pt() = L(step.start.pt());
    }

    /// Performs a step with R registers per vector of stages.
    template <int R, class System, class S, int N>
    static void step_with_registers(const System& system, StepperState<S, N>& step, const Coefficients& coefficients) {
        using L = Lanes<S, R>;
        const int s = stages(coefficients);
        static_assert(lane_count<L> <= max_stages, "a vector must not have more lanes than a row of `g` has elements");
        const StageColumns<S>& columns = detail::stage_columns<S>[s - 1];
        alignas(64) S g[phase_size * max_stages] = {};
        PhaseGradient<L> gradients;
        detail::for_each_component([&](int k) __attribute__((always_inline)) {
            gradients[k] = sum<L>(row(stage_memory(step), k), columns.extrapolation, s);
        });
        store_gradients(gradients, g);
        Convergence<S> convergence(step);
        S iterations(0);
        for (int iteration = 0; iteration < Convergence<S>::max_iterations && any(convergence.unconverged());
             ++iteration) {
            iterations += S(1);
            ++step.issued_iterations;
            State<L> y;
            stage_states(step, g, columns, s, y);
            PhaseGradient<L> new_gradients;
            L change_q(S(0)), change_p(S(0));
            system.derivatives(y, new_gradients);
            detail::for_each_component([&](int k) __attribute__((always_inline)) {
                L& change = k < space_size ? change_p : change_q;
                change = max(change, abs(new_gradients[k] - gradients[k]));
                gradients[k] = new_gradients[k];
            });
            store_gradients(gradients, g);
            convergence.update(convergence.relative(abs(step.h) * detail::greatest_lane(change_q),
                                                    abs(step.h) * detail::greatest_lane(change_p)));
        }
        step.solved = !convergence.unconverged();
        step.gradients = fma(iterations, S(s), step.gradients);
        step.lane_iterations += iterations;
        if (!step.solved)
            SharedSolvers<S, N>::newton_stages(as_called<S>(system), step, coefficients.gauss->template numbers<S>(), s,
                                               g, 1, max_stages);
        finish<L>(system, step, coefficients.gauss->template numbers<S>(), columns, s, g);
    }
    /// Stores the gradients at all stages in the array g.
    template <class L, class S>
    KAGERO_INLINE static void store_gradients(const PhaseGradient<L>& gradients, S* g) {
        detail::for_each_component(
            [&](int k) __attribute__((always_inline)) { detail::store(gradients[k], row(g, k)); });
    }

    /// Computes the state and the carried quantities at the end of the step, as `Gauss::finish` does.
    template <class L, class System, class S, int N>
    KAGERO_INLINE static void finish(const System& system, StepperState<S, N>& step, const GaussNumbers<S>& numbers,
                                     const StageColumns<S>& columns, int s, const S* g) {
        step.end.pt() = step.start.pt();
        for (int k = 0; k < phase_size; ++k) {
            const S* stage_gradients = row(g, conjugate(k));
            S total = numbers.b[0] * stage_gradients[0];
            for (int j = 1; j < s; ++j) total = fma(numbers.b[j], stage_gradients[j], total);
            const S rounding_error = step.start.stepper_memory[k];
            const S change = k < space_size ? fma(step.h, total, rounding_error) : fnma(step.h, total, rounding_error);
            step.end.y[k] = step.start.y[k] + change;
            step.end.stepper_memory[k] = change - (step.end.y[k] - step.start.y[k]);
        }
        advance_parameter_only(step);
        if (integrates_carried(system, step)) {
            State<L> y;
            stage_states(step, g, columns, s, y);
            CarriedSums<S, N> carried;
            carried.add_lanes(system, numbers.b, s, y);
            carried.finish_stages(system, step);
        }
        detail::for_each_component([&](int k) __attribute__((always_inline)) {
            std::memcpy(row(stage_memory(step), k), row(g, k), max_stages * sizeof(S));
        });
    }
};

}  // namespace kagero
