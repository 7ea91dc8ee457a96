/// Conservation of H by a method, measured along a few rays.
#pragma once

#include "plan/variant.h"

namespace kagero {

/// Relative energy errors |H − H0| / (½|p0|² + |H0|), where p0 is the momentum at the start of the ray. Each member is
/// the maximum over the rays.
struct EnergyDrift {
    double max = 0;          ///< Maximum over the steps.
    double first_tenth = 0;  ///< Mean over the first tenth of the steps.
    double last_tenth = 0;   ///< Mean over the last tenth of the steps.
};

/// Traces the rays with the variant and returns the energy drift.
EnergyDrift energy_drift(const Plan& plan, const Variant& variant, const std::vector<RayStart>& rays);

/// Signed relative energy errors (H − H0) / (½|p0|² + |H0|) along one ray.
struct EnergyTrace {
    const IntegratorInfo* info = nullptr;
    double step = 0;       ///< Step in the unit of a scene file, or the tolerance of an adaptive method.
    double gradients = 0;  ///< Gradient evaluations per ray, mean over the sample rays.
    std::vector<std::array<double, 2>> points;  ///< Pairs (λ, error) at the ray start and after every step.
};

/// Traces one ray with the variant and returns its energy errors. `gradients` is not set.
EnergyTrace energy_trace(const Plan& plan, const Variant& variant, const RayStart& ray);

}  // namespace kagero
