/// The definitions of what all Hamiltonians share; each value type is instantiated in one translation unit.
#pragma once

#include "kernels/integrators/composition.h"
#include "kernels/integrators/gauss.h"
#include "kernels/integrators/newton.h"
#include "kernels/integrators/newton_stages.h"
#include "kernels/integrators/runge_kutta.h"

/// The kinds of step that are shareable, on a value type.
#define KAGERO_SHARED_STEPS(...)                         \
    template struct SharedStep<Composition, __VA_ARGS__>; \
    template struct SharedStep<RungeKutta, __VA_ARGS__>;  \
    template struct SharedStep<Gauss<0>, __VA_ARGS__>;    \
    template struct SharedStep<Gauss<4>, __VA_ARGS__>;

namespace kagero {

template <class Step, class V, int N>
void SharedStep<Step, V, N>::begin(const CalledSystem<V, N>& system, Flow<V, N>& f, const Coefficients& coefficients) {
    Step::begin(system, f, coefficients);
}
template <class Step, class V, int N>
void SharedStep<Step, V, N>::step(const CalledSystem<V, N>& system, Flow<V, N>& f, const Coefficients& coefficients) {
    Step::step(system, f, coefficients);
}

template <class V, int N>
Curve<V> Shared<V, N>::collocation_curve(const Flow<V, N>& f, const Coefficients& coefficients) {
    const auto velocity = [&f](int j) { return velocity_in(f.stage[j]); };
    return Curve<V>::collocation(f, coefficients.gauss->template numbers<S>(), coefficients.gauss->stages, velocity);
}

}  // namespace kagero
