/// The definition of `space_kernel`: a Hamiltonian joined with every kind of step.
#pragma once

#include "kernels/integrators/carried.h"
#include "kernels/methods/space_kernel.h"

namespace kagero {

/// A ray that needs no integrator.
struct Straight {
    template <class System, class V>
    static void begin(const System&, Flow<V>&, const Coefficients&) {}
    template <class System, class V>
    static void step(const System&, Flow<V>& f, const Coefficients&) {
        static_assert(!refusal_to_carry<System>(), "a straight step integrates nothing that a ray carries beside λ");
        f.end.set(advance(f.start.q(), f.h, f.start.velocity), f.start.p());
        carry_evenly(f);
        f.solved = always<V>();
    }
};

namespace detail {

/// This share of H's terms a ray may have lost at the end of a step: one that has lost more is another ray.
template <class S>
inline constexpr S greatest_loss = S(0.03);

/// What the tracing loop wants to know of a place on a ray's way. Not inlined, so that all kinds of step share it.
template <class System, class V>
__attribute__((noinline)) void look_around(const System& system, Flow<V>& f, Waypoint<V>& at, const V& terms_before) {
    using S = ScalarOf<V>;
    const Survey<V> here = system.survey(at);
    at.velocity = here.velocity, at.energy_terms = here.terms;
    at.domain = here.domain, at.captured = here.captured, at.side = here.side, at.scale = here.scale;
    if (f.capture_within < std::numeric_limits<S>::infinity()) {
        const Vec3<V> q = at.q(), stretched{q.x, q.y, V(f.capture_stretch) * q.z};
        at.captured = max(at.captured, norm(stretched) - V(f.capture_within));
    }
    // Relative to the greater of both ends: where a ray turns back, p may vanish.
    const V terms = max(here.terms, terms_before);
    f.energy_holds = (here.excess * here.excess <= V(greatest_loss<S> * greatest_loss<S>) * terms) & (terms - terms <= V(S(0)));  // and these are finite
    if (f.want_energy) f.energy_error = abs(here.excess) / here.size;
    if (f.want_path) f.energy = system.energy(at) + V(S(system.level()));
}

/// At the end of a step.
template <class System, class V>
KAGERO_INLINE void arrive(const System& system, Flow<V>& f) {
    f.end.pt() = f.start.pt();
    look_around(system, f, f.end, f.start.energy_terms);
}

/// … and at the start of a ray, which is the end of no step.
template <class System, class V>
KAGERO_INLINE void depart(const System& system, Flow<V>& f) {
    look_around(system, f, f.start, V(ScalarOf<V>(0)));
}

/// Whether this step is compiled for all called systems together.
template <class System, class Step>
constexpr bool is_shared() {
    if constexpr (is_called<System>() && requires { Step::template shareable<System>(); }) return Step::template shareable<System>();
    else return false;
}

/// A system as this step sees it, so that what is the same of several systems is compiled once.
template <class System, class Step>
const auto& stepped_in(const SystemStorage& storage) {
    const System& system = system_in<System>(storage);
    if constexpr (!requires { typename System::Whole; }) return system;
    else if constexpr (requires { Step::takes_sides; }) return static_cast<const typename System::OneSided&>(system);
    else return static_cast<const typename System::Whole&>(system);
}

template <class System, class Step, class V>
void begin(const SystemStorage& storage, Flow<V>& f, const Coefficients& coefficients) {
    const auto& system = stepped_in<System, Step>(storage);
    depart(stepped_in<System, Straight>(storage), f);
    if constexpr (is_shared<System, Step>()) SharedStep<Step, V>::begin(as_called<V>(system), f, coefficients);
    else Step::begin(system, f, coefficients);
}

template <class System, class Step, class V>
void step(const SystemStorage& storage, Flow<V>& f, const Coefficients& coefficients) {
    const auto& system = stepped_in<System, Step>(storage);
    if constexpr (is_shared<System, Step>()) SharedStep<Step, V>::step(as_called<V>(system), f, coefficients);
    else Step::step(system, f, coefficients);
    arrive(stepped_in<System, Straight>(storage), f);
    if constexpr (requires { Step::arrived(f); }) Step::arrived(f);
}

template <class System, class Step, class V>
void pass(const SystemStorage& storage, Flow<V>& f, const Coefficients& coefficients, Passage<V>& way) {
    const System& system = system_in<System>(storage);
    Step::pass(system, f, coefficients, way);
    const V worst = f.energy_error;
    arrive(system, f);
    Step::arrived(f);
    if (f.want_energy) f.energy_error = max(f.energy_error, worst);
}

/// Where the slope of H jumps steps end; a derivative taken there, or in a stage that reaches across, is that of the wrong side.
template <class System, class Step>
constexpr const char* refusal() {
    if constexpr (System::creased && !requires { Step::stages_inside; })
        return "it takes derivatives on the surface where the slope of this H jumps, and loses its order there";
    else
        return Step::template refusal<System>();
}

template <class System, class Step, class V>
constexpr void add_step(SpaceKernel<V>& kernel, int kind) {
    kernel.begin[kind] = begin<System, Step, V>;
    kernel.step[kind] = step<System, Step, V>;
    if constexpr (requires { Step::template curve<V>; }) kernel.curve[kind] = Step::template curve<V>;
    if constexpr (requires { Step::template pass<System, V>; }) kernel.pass[kind] = pass<System, Step, V>;
}

/// All but the kinds of step.
template <class System, class V>
constexpr SpaceKernel<V> kernel_without_steps() {
    SpaceKernel<V> kernel{};
    kernel.creased = System::creased, kernel.scaled = System::scaled;
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
        visit_kind(static_cast<Kind>(k), [&]<class Step>() {
            kernel.refusal[k] = refusal<System, Step>();
            if constexpr (!refusal<System, Step>()) add_step<System, Step>(kernel, k);
        });
    }
    if constexpr (std::is_same_v<ScalarOf<V>, double> && lane_count<V> > 1) {
        kernel.derivatives = [](const SystemStorage& storage) { return system_in<System>(storage).listed(); };
        kernel.pace = [](const SystemStorage& storage, const State<V>& s) { return system_in<System>(storage).pace(s); };
    }
    if constexpr (System::creased)
        kernel.side = [](const SystemStorage& storage, const State<V>& s) { return system_in<System>(storage).survey(s).side; };
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
