/// The definition of `space_kernel`: a Hamiltonian joined with every kind of step.
#pragma once

#include "kernels/integrators/carried.h"
#include "kernels/methods/space_kernel.h"

namespace kagero {

/// A ray that needs no integrator.
struct Straight {
    template <class System, class V>
    static void begin(const System&, StepperState<V>&, const Coefficients&) {}
    template <class System, class V>
    static void step(const System&, StepperState<V>& f, const Coefficients&) {
        static_assert(!refusal_to_carry<System>(), "a straight step integrates nothing that a ray carries beside λ");
        f.end.set(advance(f.start.q(), f.h, f.start.velocity), f.start.p());
        carry_evenly(f);
        f.solved = always<V>();
    }
};

namespace detail {

/// The share of H's terms that a ray may have lost at the end of a step; a ray that has lost more has become another
/// ray.
template <class S>
inline constexpr S greatest_loss = S(0.03);

/// Evaluates what the tracing loop needs at a state: velocity, event functions and H. Not inlined, so that all kinds of
/// stepper share it.
template <class System, class V>
__attribute__((noinline)) void evaluate_event_functions(const System& system, StepperState<V>& f, RayState<V>& at,
                                                        const V& terms_before) {
    using S = ScalarOf<V>;
    const EventFunctions<V> here = system.event_functions(at);
    at.velocity = here.velocity, at.energy_terms = here.terms;
    at.domain = here.domain, at.captured = here.captured, at.switching = here.switching,
    at.max_step_length = here.max_step_length;
    if (f.options.capture_within < std::numeric_limits<S>::infinity()) {
        const Vec3<V> q = at.q(), stretched{q.x, q.y, V(f.options.capture_stretch) * q.z};
        at.captured = max(at.captured, norm(stretched) - V(f.options.capture_within));
    }
    // Relative to the greater of both ends: where a ray turns back, p may vanish.
    const V terms = max(here.terms, terms_before);
    f.energy_holds = (here.excess * here.excess <= V(greatest_loss<S> * greatest_loss<S>) * terms) &
                     (terms - terms <= V(S(0)));  // and these are finite
    if (f.options.want_energy) f.energy_error = abs(here.excess) / here.size;
    if (f.options.want_path) f.energy = system.energy(at) + V(S(system.level()));
}

/// At the end of a step.
template <class System, class V>
KAGERO_INLINE void evaluate_end(const System& system, StepperState<V>& f) {
    f.end.pt() = f.start.pt();
    evaluate_event_functions(system, f, f.end, f.start.energy_terms);
}

/// At the start of a ray, where no step has ended.
template <class System, class V>
KAGERO_INLINE void evaluate_start(const System& system, StepperState<V>& f) {
    evaluate_event_functions(system, f, f.start, V(ScalarOf<V>(0)));
}

/// Whether this step is compiled for all called systems together.
template <class System, class Stepper>
constexpr bool is_shared() {
    if constexpr (is_called<System>() && requires { Stepper::template shareable<System>(); })
        return Stepper::template shareable<System>();
    else return false;
}

/// A system as this step sees it, so that what is the same of several systems is compiled once.
template <class System, class Stepper>
const auto& stepped_in(const SystemStorage& storage) {
    const System& system = system_in<System>(storage);
    if constexpr (!requires { typename System::Whole; }) return system;
    else if constexpr (requires { Stepper::takes_sides; }) return static_cast<const typename System::OneSided&>(system);
    else return static_cast<const typename System::Whole&>(system);
}

template <class System, class Stepper, class V>
void begin(const SystemStorage& storage, StepperState<V>& f, const Coefficients& coefficients) {
    const auto& system = stepped_in<System, Stepper>(storage);
    evaluate_start(stepped_in<System, Straight>(storage), f);
    if constexpr (is_shared<System, Stepper>()) SharedStepper<Stepper, V>::begin(as_called<V>(system), f, coefficients);
    else Stepper::begin(system, f, coefficients);
}

template <class System, class Stepper, class V>
void step(const SystemStorage& storage, StepperState<V>& f, const Coefficients& coefficients) {
    const auto& system = stepped_in<System, Stepper>(storage);
    if constexpr (is_shared<System, Stepper>()) SharedStepper<Stepper, V>::step(as_called<V>(system), f, coefficients);
    else Stepper::step(system, f, coefficients);
    evaluate_end(stepped_in<System, Straight>(storage), f);
    if constexpr (requires { Stepper::finish(f); }) Stepper::finish(f);
}

template <class System, class Stepper, class V>
void integrate_to_escape(const SystemStorage& storage, StepperState<V>& f, const Coefficients& coefficients,
                         EscapeIntegration<V>& way) {
    const System& system = system_in<System>(storage);
    Stepper::integrate_to_escape(system, f, coefficients, way);
    const V worst = f.energy_error;
    evaluate_end(system, f);
    Stepper::finish(f);
    if (f.options.want_energy) f.energy_error = max(f.energy_error, worst);
}

/// Where the slope of H jumps steps end; a derivative taken there, or in a stage that reaches across, is that of the
/// wrong side.
template <class System, class Stepper>
constexpr const char* refusal() {
    if constexpr (System::discontinuous && !requires { Stepper::stages_inside; })
        return "it takes derivatives on the surface where the slope of this H jumps, and loses its order there";
    else
        return Stepper::template refusal<System>();
}

template <class System, class Stepper, class V>
constexpr void add_step(SpaceKernel<V>& kernel, int kind) {
    kernel.begin[kind] = begin<System, Stepper, V>;
    kernel.step[kind] = step<System, Stepper, V>;
    if constexpr (requires { Stepper::template curve<V>; }) kernel.curve[kind] = Stepper::template curve<V>;
    if constexpr (requires { Stepper::template integrate_to_escape<System, V>; })
        kernel.integrate_to_escape[kind] = integrate_to_escape<System, Stepper, V>;
}

/// All but the kinds of step.
template <class System, class V>
constexpr SpaceKernel<V> kernel_without_steps() {
    SpaceKernel<V> kernel{};
    kernel.discontinuous = System::discontinuous, kernel.bounds_steps = System::bounds_steps;
    kernel.bounded = System::bounded, kernel.capturing = System::capturing;
    kernel.cyclic = System::cyclic;
    kernel.operations = System::operations;
    kernel.construct = [](SystemStorage& storage, const double* parameters) { new (storage.bytes) System(parameters); };
    kernel.begin_straight = begin<System, Straight, V>;
    kernel.step_straight = step<System, Straight, V>;
    return kernel;
}

template <class System, class V>
constexpr SpaceKernel<V> make_space_kernel() {
    SpaceKernel<V> kernel = kernel_without_steps<System, V>();
    for (int k = 0; k < kind_count; ++k) {
        visit_kind(static_cast<Kind>(k), [&]<class Stepper>() {
            kernel.refusal[k] = refusal<System, Stepper>();
            if constexpr (!refusal<System, Stepper>()) add_step<System, Stepper>(kernel, k);
        });
    }
    if constexpr (std::is_same_v<ScalarOf<V>, double> && lane_count<V> > 1) {
        kernel.derivatives = [](const SystemStorage& storage) { return system_in<System>(storage).listed(); };
        kernel.time_rescaling_factor = [](const SystemStorage& storage, const State<V>& s) {
            return system_in<System>(storage).time_rescaling_factor(s);
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
    static constexpr SpaceKernel<V> plain = detail::make_space_kernel<System<H, false, S>, V>();
    if constexpr (Rescalable<H>) {
        static constexpr SpaceKernel<V> transformed = detail::make_space_kernel<System<H, true, S>, V>();
        if (rescaled) return transformed;
    }
    return plain;
}

}  // namespace kagero
