/// The kernels of formulas: those for smooth H, for H with kinks, and for H with discontinuous derivatives.
#pragma once

#include "kernels/formula/formula_system.h"
#include "kernels/methods/steppers.h"

namespace kagero::formula {

/// The kernels of formulas that use the same system and the same steppers.
template <class V>
struct FormulaKernels {
    SpaceKernel<V> smooth, kinked, discontinuous;

    /// Returns the kernel for these programs.
    const SpaceKernel<V>& of(const Programs& programs) const {
        return programs.discontinuous ? discontinuous : programs.has_kinks ? kinked : smooth;
    }
};

/// Returns SpaceKernel::energy_jump. A continuous K changes in a step h by at most h |∂K/∂q| |∂K/∂p|, with the greatest
/// derivatives in the step. They are taken at its ends and between them, because a ray that grazes a thin layer enters
/// and leaves it in one step.
template <class System, class V>
V energy_jump(const System& system, const State<V>& start, const State<V>& end, const V& h) {
    using S = ScalarOf<V>;
    const EventFunctions<V> before = system.event_functions(start), behind = system.event_functions(end);
    State<V> middle = start;
    for (int i = 0; i < phase_size; ++i) middle.y[i] = V(S(0.5)) * (start.y[i] + end.y[i]);
    V rates(S(0));
    for (const State<V>& state : {start, middle, end}) {
        V d[phase_size];
        system.derivatives(state, d);
        rates = rates + sqrt((d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) * (d[3] * d[3] + d[4] * d[4] + d[5] * d[5]));
    }
    constexpr S reserve = 16;  // for methods of high order: the absolute values of their weights have sums up to 13
    const V change = abs(behind.energy_residual - before.energy_residual) - V(reserve) * abs(h) * rates;
    return max(change, V(S(0))) / sqrt(before.squared_energy_terms);
}

/// Returns the kernels that consist of the functions of `kernel`, which is that of `System`.
template <class System, class V>
constexpr FormulaKernels<V> kernels_from(SpaceKernel<V> kernel) {
    kernel.switching_function = [](const SystemStorage& storage, const State<V>& s) {
        return kagero::detail::system_in<System>(storage).switching_function(s);
    };
    kernel.energy_jump = [](const SystemStorage& storage, const State<V>& start, const State<V>& end, const V& h) {
        return energy_jump(kagero::detail::system_in<System>(storage), start, end, h);
    };
    FormulaKernels<V> kernels{kernel, kernel, kernel};
    kernels.kinked.kinked = true;
    kernels.discontinuous.discontinuous = true;
    for (int k = 0; k < kind_count; ++k)
        if (!kernels.discontinuous.refusal[k])
            kernels.discontinuous.refusal[k] = visit_kind(static_cast<StepperKind>(k), []<class Stepper>() {
                return kagero::detail::refusal_of_discontinuity<Stepper>();
            });
    return kernels;
}

// These functions are compiled in the file of the default packets, and in that of single rays.
#define KAGERO_INTERPRETER(PREFIX, V)                                              \
    PREFIX template void evaluate_interpreted(const Code&, const V*, V*);           \
    PREFIX template void evaluate_interpreted(const Code&, const Dual<V, space_size>*, Dual<V, space_size>*); \
    PREFIX template void interpret<V, 1>(const Code&, int, int, V*);               \
    PREFIX template void interpret<V, 3>(const Code&, int, int, V*);               \
    PREFIX template void interpret<V, 4>(const Code&, int, int, V*);

}  // namespace kagero::formula
