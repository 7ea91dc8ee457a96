/// The definition of `space_kernel`: a Hamiltonian joined with every kind of step.
#pragma once

#include "kernels/stepping/space_kernel.h"

namespace kagero {

/// A ray that needs no integrator.
struct Straight {
    template <class System, class V>
    static void begin(const System&, Flow<V>&, const Coefficients&) {}
    template <class System, class V>
    static void step(const System&, Flow<V>& f, const Coefficients&) {
        f.end = f.start;
        f.end.set(advance(f.start.q(), f.h, f.start_velocity), f.start.p());
        f.end_parameter = f.start_parameter + f.h;
        f.solved = V(ScalarOf<V>(0)) <= V(ScalarOf<V>(0));
    }
};

namespace detail {

template <class System>
const System& system_in(const SystemStorage& storage) {
    static_assert(sizeof(System) <= sizeof(SystemStorage) && alignof(System) <= alignof(SystemStorage));
    return *reinterpret_cast<const System*>(storage.bytes);
}

/// A step may lose this share of H's terms; one that loses more leads to a state that has little to do with the ray.
template <class S>
inline constexpr S greatest_loss = S(0.1);

/// |H − H0| relative to the size of H's terms, at state s.
template <class System, class V>
V watch_energy(const System& system, const State<V>& s, Flow<V>& f) {
    using S = ScalarOf<V>;
    V excess, pv, size;
    system.energy(s, excess, pv, size);
    const S level = system.level();
    f.energy = excess + V(level);
    f.energy_size = size + V(level < 0 ? -level : level);
    f.energy_error = abs(excess) / (abs(pv) + V(level < 0 ? -level : level));
    return abs(excess);
}

/// Whether a system bounds its steps.
template <class System, class V>
concept BoundsSteps = requires(const System& system, const State<V>& s) { system.scale(s); };

/// What the loop wants to know of the start of a ray. Not inlined, so that all kinds of step share it; so is `arrive`.
template <class System, class V>
__attribute__((noinline)) void depart(const System& system, Flow<V>& f) {
    f.start_velocity = system.dp(f.start);
    f.start_domain = f.domain = system.domain(f.start);
    f.start_side = f.side = system.surface(f.start);
    f.captured = system.captured(f.start.q(), f.start_velocity, f.start.y[6]);
    if constexpr (BoundsSteps<System, V>) f.start_scale = system.scale(f.start);
    if (f.want_energy || f.test_energy) watch_energy(system, f.start, f), f.start_energy_size = f.energy_size;
}
/// … and of the end of a step.
template <class System, class V>
__attribute__((noinline)) void arrive(const System& system, Flow<V>& f) {
    f.end.y[6] = f.start.y[6];
    f.end_velocity = system.dp(f.end);
    f.domain = system.domain(f.end);
    if constexpr (Creased<typename System::Hamiltonian>) f.side = system.surface(f.end);
    if constexpr (BoundsSteps<System, V>) f.scale = system.scale(f.end);
    if (f.want_energy || f.test_energy) {
        // Relative to the greater of both ends: where a ray turns back, p may vanish.
        const V lost = watch_energy(system, f.end, f);
        f.energy_holds = lost <= V(greatest_loss<ScalarOf<V>>) * max(f.energy_size, f.start_energy_size);
    }
    f.captured = system.captured(f.end.q(), f.end_velocity, f.start.y[6]);
}

template <class System, class Step, class V>
void begin(const SystemStorage& storage, Flow<V>& f, const Coefficients& coefficients) {
    const System& system = system_in<System>(storage);
    depart(system, f);
    Step::begin(system, f, coefficients);
}

template <class System, class Step, class V>
void step(const SystemStorage& storage, Flow<V>& f, const Coefficients& coefficients) {
    const System& system = system_in<System>(storage);
    Step::step(system, f, coefficients);
    arrive(system, f);
}

/// Where the slope of H jumps steps end; a derivative taken there, or in a stage that reaches across, is that of the wrong side.
template <class System, class Step>
constexpr const char* refusal() {
    if constexpr (Creased<typename System::Hamiltonian> && !requires { Step::stages_inside; })
        return "it takes derivatives on the surface where the slope of this H jumps, and loses its order there";
    else
        return Step::template refusal<System>();
}

template <class System, class V>
constexpr SpaceKernel<V> make_space_kernel() {
    SpaceKernel<V> kernel{};
    kernel.creased = Creased<typename System::Hamiltonian>;
    kernel.scaled = BoundsSteps<System, V>;
    kernel.construct = [](SystemStorage& storage, const double* parameters) { new (storage.bytes) System(parameters); };
    for (int k = 0; k < kind_count; ++k) {
        visit_kind(static_cast<Kind>(k), [&]<class Step>() {
            kernel.refusal[k] = refusal<System, Step>();
            if constexpr (!refusal<System, Step>()) {
                kernel.begin[k] = begin<System, Step, V>;
                kernel.step[k] = step<System, Step, V>;
            }
        });
    }
    kernel.begin_straight = begin<System, Straight, V>;
    kernel.step_straight = step<System, Straight, V>;
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
