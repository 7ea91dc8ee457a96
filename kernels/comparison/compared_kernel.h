/// The definition of `compared_kernel`: a Hamiltonian joined with the kinds of step that each way of tracing is
/// compared by.
#pragma once

#include "kernels/comparison/forward_system.h"
#include "kernels/comparison/stages_in_lanes.h"
#include "kernels/methods/steppers.h"
#include "kernels/comparison/compared.h"

namespace kagero {
namespace detail {

/// The same system under another name, so that its steps are compiled once more, with other flags.
template <class H, bool Rescaled, class S>
struct AutoVectorizedSystem : System<H, Rescaled, S> {
    using System<H, Rescaled, S>::System;
};

/// Which step stands for a kind: `choose.operator()<kind>()` names it by a value of its type; void where there is none.
template <class System, class V, class Choose>
constexpr SpaceKernel<V> kernel_of_kinds(const Choose& choose, const char* why_not) {
    SpaceKernel<V> kernel = kernel_without_steps<System, V>();
    const auto fill = [&]<int k>() {
        using Stepper = typename decltype(choose.template operator()<static_cast<Kind>(k)>())::type;
        if constexpr (std::is_void_v<Stepper>) {
            kernel.refusal[k] = why_not;
        } else {
            kernel.refusal[k] = refusal<System, Stepper>();
            if constexpr (!refusal<System, Stepper>()) add_step<System, Stepper>(kernel, k);
        }
    };
    [&]<int... k>(std::integer_sequence<int, k...>) { (fill.template operator()<k>(), ...); }
    (std::make_integer_sequence<int, kind_count>{});
    return kernel;
}

template <class Stepper>
using Chosen = std::type_identity<Stepper>;

struct StageSteps {
    template <Kind kind>
    constexpr auto operator()() const {
        if constexpr (kind == Kind::gauss) return Chosen<StagesInLanes<0>>{};
        else if constexpr (kind == Kind::gauss_of_4) return Chosen<StagesInLanes<4>>{};
        else return Chosen<void>{};
    }
};
/// The steppers for the H of a space that declares a rescaling: only the one in the orbit plane. Straight rays need
/// none, and all others integrate the rescaled H.
struct PlainSteps {
    template <Kind kind>
    constexpr auto operator()() const {
        if constexpr (kind == Kind::orbit) return Chosen<Orbit>{};
        else return Chosen<void>{};
    }
};
/// All that may turn out the cheapest: neither the printed recipe nor the exact split does.
struct WidthSteps {
    template <Kind kind>
    constexpr auto operator()() const {
        if constexpr (kind == Kind::recipe || kind == Kind::exact_split || kind == Kind::orbit) return Chosen<void>{};
        else return Chosen<typename StepperOf<kind>::type>{};
    }
};

template <class Way, class H, bool Rescaled>
constexpr auto make_compared_kernel() {
    using V = typename Way::Value;
    using S = ScalarOf<V>;
    if constexpr (Way::form == Form::gradient) return make_space_kernel<ForwardSystem<H, Rescaled, S>, V>();
    else if constexpr (Way::form == Form::stages)
        return kernel_of_kinds<System<H, Rescaled, S>, V>(
            StageSteps{}, "only Gauss-Legendre methods have stages to put in the lanes");
    else {
        using Own = std::conditional_t<Way::form == Form::auto_vectorized, AutoVectorizedSystem<H, Rescaled, S>,
                                       System<H, Rescaled, S>>;
        if constexpr (Rescaled == Rescalable<H>)
            return kernel_of_kinds<Own, V>(WidthSteps{}, "it is not compiled for this kind of step");
        else
            return kernel_of_kinds<Own, V>(PlainSteps{},
                                           "of this space it is compiled for the rescaled Hamiltonian alone");
    }
}

}  // namespace detail

template <class Way, class H>
const SpaceKernel<typename Way::Value>& compared_kernel(bool rescaled) {
    static constexpr auto plain = detail::make_compared_kernel<Way, H, false>();
    if constexpr (Rescalable<H>) {
        static constexpr auto transformed = detail::make_compared_kernel<Way, H, true>();
        if (rescaled) return transformed;
    }
    return plain;
}

}  // namespace kagero
