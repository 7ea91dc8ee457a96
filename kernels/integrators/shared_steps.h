/// Definitions of the code that shared.h declares. Each value type is instantiated in one translation unit.
#pragma once

#include "kernels/integrators/composition.h"
#include "kernels/integrators/gauss.h"
#include "kernels/integrators/newton.h"
#include "kernels/integrators/newton_stages.h"
#include "kernels/integrators/runge_kutta.h"

/// Instantiates the shareable steppers for one value type; Gauss<0> reads its number of stages from its coefficients.
#define KAGERO_SHARED_STEPPERS(...)                         \
    template struct SharedStepper<Composition, __VA_ARGS__>; \
    template struct SharedStepper<RungeKutta, __VA_ARGS__>;  \
    template struct SharedStepper<Gauss<0>, __VA_ARGS__>;    \
    template struct SharedStepper<Gauss<4>, __VA_ARGS__>;

namespace kagero {

template <class Stepper, class V, int N>
void SharedStepper<Stepper, V, N>::begin(const CalledSystem<V, N>& system, StepperState<V, N>& step,
                                         const Coefficients& coefficients) {
    Stepper::begin(system, step, coefficients);
}
template <class Stepper, class V, int N>
void SharedStepper<Stepper, V, N>::step(const CalledSystem<V, N>& system, StepperState<V, N>& step,
                                        const Coefficients& coefficients) {
    Stepper::step(system, step, coefficients);
}

template <class V, int N>
Curve<V> SharedSolvers<V, N>::collocation_curve(const StepperState<V, N>& step, const Coefficients& coefficients) {
    const auto velocity = [&step](int j) { return velocity_in(step.stage[j]); };
    return Curve<V>::collocation(step, coefficients.gauss->template numbers<S>(), coefficients.gauss->stages, velocity);
}

}  // namespace kagero
