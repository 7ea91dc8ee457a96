/// Definition of `compared_kernel`: for each vectorization, the kernel of a Hamiltonian with the steppers that this
/// vectorization supports.
#pragma once

#include "kernels/comparison/forward_system.h"
#include "kernels/comparison/stages_in_lanes.h"
#include "kernels/methods/steppers.h"
#include "kernels/comparison/compared.h"

namespace kagero {
namespace detail {

/// The same as `System<H, Rescaled, S>`, but a different type. Its steppers are therefore compiled a second time, with
/// the compiler flags of the vectorization `AutoVectorized`.
template <class H, bool Rescaled, class S>
struct AutoVectorizedSystem : System<H, Rescaled, S> {
    using System<H, Rescaled, S>::System;
};

/// Returns a kernel with the steppers that `selection` selects. `selection.operator()<kind>()` returns the stepper for
/// a kind as `Selected<Stepper>`, or `Selected<void>` if the kind is not supported. `reason` is the refusal for kinds
/// that are not supported.
template <class System, class V, class Selection>
constexpr SpaceKernel<V> kernel_of_selection(const Selection& selection, const char* reason) {
    SpaceKernel<V> kernel = kernel_for_straight_rays<System, V>();
    const auto fill = [&]<int k>() {
        using Stepper = typename decltype(selection.template operator()<static_cast<StepperKind>(k)>())::type;
        if constexpr (std::is_void_v<Stepper>) {
            kernel.refusal[k] = reason;
        } else {
            kernel.refusal[k] = refusal<System, Stepper>();
            if constexpr (!refusal<System, Stepper>()) add_step<System, Stepper>(kernel, k);
        }
    };
    [&]<int... k>(std::integer_sequence<int, k...>) { (fill.template operator()<k>(), ...); }
    (std::make_integer_sequence<int, kind_count>{});
    return kernel;
}

/// The result of a selection: a stepper, or void.
template <class Stepper>
using Selected = std::type_identity<Stepper>;

/// Selects only the Gauss methods, with their stages in the lanes.
struct SteppersForStages {
    template <StepperKind kind>
    constexpr auto operator()() const {
        if constexpr (kind == StepperKind::gauss) return Selected<StagesInLanes<0>>{};
        else if constexpr (kind == StepperKind::gauss_4_stages) return Selected<StagesInLanes<4>>{};
        else return Selected<void>{};
    }
};
/// Selects only the orbit stepper, which refuses time rescaling. If H declares Ω, this is the selection for the kernel
/// without time rescaling. All other steppers are compiled only for the kernel with time rescaling.
struct SteppersWithoutRescaling {
    template <StepperKind kind>
    constexpr auto operator()() const {
        if constexpr (kind == StepperKind::orbit) return Selected<Orbit>{};
        else return Selected<void>{};
    }
};
/// Selects the steppers that may be the cheapest for a space. The recipe as printed and the exact splitting are never
/// the cheapest. The orbit stepper is not selected, because it refuses time rescaling (see SteppersWithoutRescaling).
struct CompetitiveSteppers {
    template <StepperKind kind>
    constexpr auto operator()() const {
        if constexpr (kind == StepperKind::recipe || kind == StepperKind::exact_split || kind == StepperKind::orbit)
            return Selected<void>{};
        else return Selected<typename StepperOf<kind>::type>{};
    }
};

inline constexpr const char* only_gauss_methods = "only Gauss-Legendre methods have stages to put in the lanes";
inline constexpr const char* not_compiled_for_method = "this kernel is not compiled for this method";

/// Returns the kernel of a Hamiltonian, with or without time rescaling, for a vectorization.
template <class Vectorization, class H, bool Rescaled>
constexpr auto make_compared_kernel() {
    using V = typename Vectorization::Value;
    using S = ScalarOf<V>;
    if constexpr (Vectorization::form == Form::gradient) return make_space_kernel<ForwardSystem<H, Rescaled, S>, V>();
    else if constexpr (Vectorization::form == Form::stages)
        return kernel_of_selection<System<H, Rescaled, S>, V>(SteppersForStages{}, only_gauss_methods);
    else {
        using SystemType = std::conditional_t<Vectorization::form == Form::auto_vectorized,
                                              AutoVectorizedSystem<H, Rescaled, S>, System<H, Rescaled, S>>;
        if constexpr (Rescaled == Rescalable<H>)
            return kernel_of_selection<SystemType, V>(CompetitiveSteppers{}, not_compiled_for_method);
        else
            return kernel_of_selection<SystemType, V>(
                SteppersWithoutRescaling{}, "for this space, this kernel is compiled only with time rescaling");
    }
}

}  // namespace detail

template <class Vectorization, class H>
const SpaceKernel<typename Vectorization::Value>& compared_kernel(bool rescaled) {
    static constexpr auto without_rescaling = detail::make_compared_kernel<Vectorization, H, false>();
    if constexpr (Rescalable<H>) {
        static constexpr auto with_rescaling = detail::make_compared_kernel<Vectorization, H, true>();
        if (rescaled) return with_rescaling;
    }
    return without_rescaling;
}

}  // namespace kagero
