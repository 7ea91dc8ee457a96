/// Definition of `space_kernel`, which combines a Hamiltonian with all steppers.
#pragma once

#include "kernels/equations/time_rate.h"
#include "kernels/integrators/carried.h"
#include "kernels/methods/space_kernel.h"

namespace kagero {

/// Stepper for straight rays, which need no integrator.
struct Straight {
    template <class System, class V>
    static void begin(const System&, StepperState<V>&, const Coefficients&) {}
    template <class System, class V>
    static void step(const System&, StepperState<V>& step, const Coefficients&) {
        static_assert(!refusal_to_carry<System>(), "a straight step integrates no carried quantity except λ");
        step.end.set(advance(step.start.q(), step.h, step.start.velocity), step.start.p());
        advance_parameter_only(step);
        step.solved = all_lanes<V>();
    }
};

namespace detail {

/// Evaluates the event functions at the state `at`, and H if options.compute_energy is set. `terms_before` is the value
/// of squared_energy_terms at the start of the step. The function is not inlined, so that all steppers share its code.
template <class System, class V>
__attribute__((noinline)) void evaluate_event_functions(const System& system, StepperState<V>& step, RayState<V>& at,
                                                        const V& terms_before) {
    using S = ScalarOf<V>;
    const EventFunctions<V> values = system.event_functions(at);
    at.velocity = values.velocity;
    at.squared_energy_terms = values.squared_energy_terms;
    at.domain = values.domain;
    at.captured = values.captured;
    at.switching = values.switching;
    at.max_step_length = values.max_step_length;
    if (step.options.capture_radius < std::numeric_limits<S>::infinity()) {
        const Vec3<V> q = at.q(), stretched{q.x, q.y, V(step.options.capture_stretch) * q.z};
        at.captured = max(at.captured, norm(stretched) - V(step.options.capture_radius));
    }
    // The error is relative to the greater terms of both ends of the step, because p may vanish where a ray turns back.
    const V terms = max(values.squared_energy_terms, terms_before);
    const MaskOf<V> finite = terms - terms <= V(S(0));
    step.energy_is_conserved = (values.energy_residual * values.energy_residual <=
                                V(max_energy_error<S> * max_energy_error<S>) * terms) & finite;
    if (step.options.compute_energy_error) step.energy_error = abs(values.energy_residual) / values.energy_scale;
    if (step.options.compute_energy) step.energy = system.unscaled_energy_residual(at) + V(system.level());
}

/// Evaluates the event functions at the end of a step.
template <class System, class V>
KAGERO_INLINE void evaluate_end(const System& system, StepperState<V>& step) {
    step.end.pt() = step.start.pt();
    evaluate_event_functions(system, step, step.end, step.start.squared_energy_terms);
}

/// Evaluates the event functions at the start of a ray.
template <class System, class V>
KAGERO_INLINE void evaluate_start(const System& system, StepperState<V>& step) {
    evaluate_event_functions(system, step, step.start, V(ScalarOf<V>(0)));
}

/// Returns true if the stepper is compiled once for all called systems.
template <class System, class Stepper>
constexpr bool is_shared() {
    if constexpr (is_called<System>() && requires { Stepper::template shareable<System>(); })
        return Stepper::template shareable<System>();
    else return false;
}

/// Returns the system as a reference to the base class that the stepper needs. Code that uses the same base class is
/// then compiled only once for several systems.
template <class System, class Stepper>
const auto& system_for(const SystemStorage& storage) {
    const System& system = system_in<System>(storage);
    if constexpr (!requires { typename System::CommonBase; }) return system;
    else if constexpr (requires { Stepper::splits_gradient; })
        return static_cast<const typename System::SplitGradientBase&>(system);
    else return static_cast<const typename System::CommonBase&>(system);
}

template <class System, class Stepper, class V>
void begin(const SystemStorage& storage, StepperState<V>& step, const Coefficients& coefficients) {
    const auto& system = system_for<System, Stepper>(storage);
    // The system is passed as for `Straight`: as the same base class for all steppers, which then share the code.
    evaluate_start(system_for<System, Straight>(storage), step);
    if constexpr (is_shared<System, Stepper>())
        SharedStepper<Stepper, V>::begin(as_called<V>(system), step, coefficients);
    else Stepper::begin(system, step, coefficients);
}

template <class System, class Stepper, class V>
void step(const SystemStorage& storage, StepperState<V>& step, const Coefficients& coefficients) {
    const auto& system = system_for<System, Stepper>(storage);
    if constexpr (is_shared<System, Stepper>())
        SharedStepper<Stepper, V>::step(as_called<V>(system), step, coefficients);
    else Stepper::step(system, step, coefficients);
    evaluate_end(system_for<System, Straight>(storage), step);
    if constexpr (requires { Stepper::finish(step); }) Stepper::finish(step);
}

template <class System, class Stepper, class V>
void integrate_to_escape(const SystemStorage& storage, StepperState<V>& step, const Coefficients& coefficients,
                         EscapeIntegration<V>& integration) {
    const System& system = system_in<System>(storage);
    Stepper::integrate_to_escape(system, step, coefficients, integration);
    const V greatest_error_before_end = step.energy_error;
    evaluate_end(system, step);
    Stepper::finish(step);
    if (step.options.compute_energy_error) step.energy_error = max(step.energy_error, greatest_error_before_end);
}

/// Returns nullptr if the stepper supports an H whose gradient is discontinuous, else the reason why not.
template <class Stepper>
constexpr const char* refusal_of_discontinuity() {
    if constexpr (requires { Stepper::stages_inside; }) return nullptr;
    else
        return "the method evaluates derivatives on the surface where the gradient of H is discontinuous, and loses "
               "its order there";
}

/// Returns nullptr if the stepper supports the system, else the reason why not. Steps end at a discontinuity of the
/// gradient of H. A gradient that is evaluated at the discontinuity may be that of the wrong side.
template <class System, class Stepper>
constexpr const char* refusal() {
    if constexpr (System::discontinuous && refusal_of_discontinuity<Stepper>())
        return refusal_of_discontinuity<Stepper>();
    else
        return Stepper::template refusal<System>();
}

/// Adds the functions of the stepper with the index `kind` to the kernel.
template <class System, class Stepper, class V>
constexpr void add_step(SpaceKernel<V>& kernel, int kind) {
    kernel.begin[kind] = begin<System, Stepper, V>;
    kernel.step[kind] = step<System, Stepper, V>;
    if constexpr (requires { Stepper::template curve<V>; }) kernel.curve[kind] = Stepper::template curve<V>;
    if constexpr (requires { Stepper::template stage_state<V>; })
        kernel.stage_state[kind] = Stepper::template stage_state<V>;
    if constexpr (requires { Stepper::template integrate_to_escape<System, V>; })
        kernel.integrate_to_escape[kind] = integrate_to_escape<System, Stepper, V>;
}

/// Returns a kernel whose only stepper is the one for straight rays.
template <class System, class V>
constexpr SpaceKernel<V> kernel_for_straight_rays() {
    SpaceKernel<V> kernel{};
    kernel.discontinuous = System::discontinuous;
    kernel.bounds_steps = System::bounds_steps;
    kernel.bounded = System::bounded;
    kernel.capturing = System::capturing;
    kernel.cyclic = System::cyclic;
    kernel.operations = System::operations;
    kernel.construct = [](SystemStorage& storage, const double* parameters) { new (storage.bytes) System(parameters); };
    kernel.gradient = [](const SystemStorage& storage, const State<V>& s, V* out) {
        system_for<System, Straight>(storage).derivatives(s, out);
    };
    if constexpr (depends_on_pt<System>())
        kernel.time_rate = [](const SystemStorage& storage, const State<V>& s) {
            return gradient_pt(system_for<System, Straight>(storage), s);
        };
    kernel.begin_straight = begin<System, Straight, V>;
    kernel.step_straight = step<System, Straight, V>;
    return kernel;
}

/// Returns the kernel of a system with all steppers that support it.
template <class System, class V>
constexpr SpaceKernel<V> make_space_kernel() {
    SpaceKernel<V> kernel = kernel_for_straight_rays<System, V>();
    for (int k = 0; k < kind_count; ++k) {
        visit_kind(static_cast<StepperKind>(k), [&]<class Stepper>() {
            kernel.refusal[k] = refusal<System, Stepper>();
            if constexpr (!refusal<System, Stepper>()) add_step<System, Stepper>(kernel, k);
        });
    }
    if constexpr (std::is_same_v<ScalarOf<V>, double> && lane_count<V> > 1) {
        kernel.derivatives = [](const SystemStorage& storage) {
            return system_in<System>(storage).derivatives_with_uniforms();
        };
        kernel.time_rescaling_factor = [](const SystemStorage& storage, const State<V>& s) {
            return system_in<System>(storage).time_rescaling_factor(s);
        };
        kernel.momentum_line = [](const SystemStorage& storage, const State<V>& s, const Vec3<V>& n) {
            return momentum_line(system_for<System, Straight>(storage), s, n);
        };
    }
    if constexpr (System::discontinuous)
        kernel.switching_function = [](const SystemStorage& storage, const State<V>& s) {
            return system_in<System>(storage).event_functions(s).switching;
        };
    return kernel;
}

}  // namespace detail

template <class H, class V>
const SpaceKernel<V>& space_kernel(bool rescaled) {
    using S = ScalarOf<V>;
    static constexpr SpaceKernel<V> kernel = detail::make_space_kernel<System<H, false, S>, V>();
    if constexpr (Rescalable<H>) {
        static constexpr SpaceKernel<V> rescaled_kernel = detail::make_space_kernel<System<H, true, S>, V>();
        if (rescaled) return rescaled_kernel;
    }
    return kernel;
}

}  // namespace kagero
