/// The definitions of `Shared` and `SharedSteps`; each value type is instantiated in one translation unit.
#pragma once

#include "kernels/stepping/methods.h"
#include "kernels/stepping/newton.h"
#include "kernels/stepping/newton_stages.h"

namespace kagero {

template <class V>
void SharedSteps<V>::begin(Kind kind, const CalledSystem<V>& system, Flow<V>& f, const Coefficients& coefficients) {
    visit_kind(kind, [&]<class Step>() {
        if constexpr (requires { Step::shared_as; }) Step::begin(system, f, coefficients);
    });
}

template <class V>
void SharedSteps<V>::step(Kind kind, const CalledSystem<V>& system, Flow<V>& f, const Coefficients& coefficients) {
    visit_kind(kind, [&]<class Step>() {
        if constexpr (requires { Step::shared_as; }) Step::step(system, f, coefficients);
    });
}

template <class V>
Curve<V> Shared<V>::collocation_curve(const Flow<V>& f, const Coefficients& coefficients) {
    const auto velocity = [&f](int j) { return Vec3<V>{f.stage[j][3], f.stage[j][4], f.stage[j][5]}; };
    return Curve<V>::collocation(f, coefficients.gauss->template numbers<S>(), coefficients.gauss->stages, velocity);
}

}  // namespace kagero
