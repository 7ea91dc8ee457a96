/// The definition of `space_kernel`: a Hamiltonian joined with every kind of step.
#pragma once

#include "kernels/stepping/space_kernel.h"

namespace kagero {

/// A ray that needs no integrator.
struct Straight {
    template <class System, class V>
    static void begin(const System&, Flow<V>&) {}
    template <class System, class V>
    static void step(const System&, Flow<V>& f, Fractions) {
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

/// |H − H0| relative to the size of H's terms, at state s.
template <class System, class V>
void watch_energy(const System& system, const State<V>& s, Flow<V>& f) {
    using S = ScalarOf<V>;
    V excess, pv;
    system.energy(s, excess, pv);
    const S level = S(System::Hamiltonian::level);
    f.energy = excess + V(level);
    f.energy_error = abs(excess) / (abs(pv) + V(level < 0 ? -level : level));
}

template <class System, class Step, class V>
void begin(const SystemStorage& storage, Flow<V>& f) {
    const System& system = system_in<System>(storage);
    f.start_velocity = system.dp(f.start);
    f.start_domain = f.domain = system.domain(f.start);
    if (f.want_energy) watch_energy(system, f.start, f);
    Step::begin(system, f);
}

template <class System, class Step, class V>
void step(const SystemStorage& storage, Flow<V>& f, [[maybe_unused]] Fractions fractions) {
    const System& system = system_in<System>(storage);
    if constexpr (requires { Step::step(system, f, fractions); }) Step::step(system, f, fractions);
    else Step::step(system, f);
    f.end.y[6] = f.start.y[6];
    f.end_velocity = system.dp(f.end);
    if (f.want_energy) watch_energy(system, f.end, f);
    if constexpr (Bounded<typename System::Hamiltonian>) f.domain = system.domain(f.end);
    else f.domain = V(ScalarOf<V>(1));
    if constexpr (Capturing<typename System::Hamiltonian>) f.captured = system.captured(f.end.q(), f.end_velocity);
    else f.captured = V(ScalarOf<V>(1));
}

template <class System, class V>
constexpr SpaceKernel<V> make_space_kernel() {
    SpaceKernel<V> kernel{};
    kernel.construct = [](SystemStorage& storage, const double* parameters) { new (storage.bytes) System(parameters); };
    for (int k = 0; k < kind_count; ++k) {
        visit_kind(static_cast<Kind>(k), [&]<class Step>() {
            kernel.refusal[k] = Step::template refusal<System>();
            if constexpr (!Step::template refusal<System>()) {
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
