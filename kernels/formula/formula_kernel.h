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

/// Returns the kernels that consist of the functions of `kernel`, which is that of `System`.
template <class System, class V>
constexpr FormulaKernels<V> kernels_from(SpaceKernel<V> kernel) {
    kernel.switching_function = [](const SystemStorage& storage, const State<V>& s) {
        return kagero::detail::system_in<System>(storage).switching_function(s);
    };
    kernel.relative_energy_residual = [](const SystemStorage& storage, const State<V>& s) {
        const EventFunctions<V> values = kagero::detail::system_in<System>(storage).event_functions(s);
        return values.energy_residual / sqrt(values.squared_energy_terms);
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
