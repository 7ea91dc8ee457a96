/// Definition of `compared_formula_kernel`: for each vectorization, the kernels of formulas.
#pragma once

#include "kernels/comparison/compared_kernel.h"
#include "kernels/comparison/forward_formula.h"
#include "kernels/formula/formula_kernel.h"

namespace kagero {
namespace formula {

KAGERO_INTERPRETER(extern, PacketDouble)
KAGERO_INTERPRETER(extern, PacketFloat)
KAGERO_INTERPRETER(extern, double)

}  // namespace formula

namespace detail {

/// Returns the kernels of formulas for a vectorization. They serve formulas with and without time rescaling, which is a
/// property of the programs.
template <class Vectorization, bool is_separable>
constexpr auto make_compared_formula_kernels() {
    using V = typename Vectorization::Value;
    using FormulaSystem = System<formula::AnyFormula<is_separable>, false, ScalarOf<V>>;
    if constexpr (Vectorization::form == Form::stages)
        return formula::kernels_from<FormulaSystem>(
            kernel_of_selection<FormulaSystem, V>(SteppersForStages{}, only_gauss_methods));
    else {
        using SystemType = std::conditional_t<Vectorization::form == Form::gradient, ForwardFormula<is_separable>,
                                              FormulaSystem>;
        return formula::kernels_from<SystemType>(
            kernel_of_selection<SystemType, V>(CompetitiveSteppers{}, not_compiled_for_method));
    }
}

}  // namespace detail

template <class Vectorization>
const SpaceKernel<typename Vectorization::Value>& compared_formula_kernel(const formula::Programs& programs) {
    static constexpr auto general = detail::make_compared_formula_kernels<Vectorization, false>(),
                          separable = detail::make_compared_formula_kernels<Vectorization, true>();
    return (programs.separable ? separable : general).of(programs);
}

}  // namespace kagero
