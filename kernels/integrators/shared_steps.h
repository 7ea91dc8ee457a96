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

template <class Step, class V>
void SharedStep<Step, V>::begin(const CalledSystem<V>& system, Flow<V>& f, const Coefficients& coefficients) {
    Step::begin(system, f, coefficients);
}
template <class Step, class V>
void SharedStep<Step, V>::step(const CalledSystem<V>& system, Flow<V>& f, const Coefficients& coefficients) {
    Step::step(system, f, coefficients);
}

template <class V>
Curve<V> Shared<V>::collocation_curve(const Flow<V>& f, const Coefficients& coefficients) {
    const auto velocity = [&f](int j) { return Vec3<V>{f.stage[j][3], f.stage[j][4], f.stage[j][5]}; };
    return Curve<V>::collocation(f, coefficients.gauss->template numbers<S>(), coefficients.gauss->stages, velocity);
}

}  // namespace kagero
