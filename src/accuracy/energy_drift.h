/// How well a method keeps H along a few rays.
#pragma once

#include "plan/variant.h"

namespace kagero {

/// |H − H0| / (½|p|² + |H0|, both at the start of the ray): the greatest, and the mean over the first and the last
/// tenth of the path. The worst of the rays.
struct EnergyDrift {
    double max = 0, first_tenth = 0, last_tenth = 0;
};

EnergyDrift energy_drift(const Plan& plan, const Variant& variant, const std::vector<RayStart>& rays);

/// The same quantity step by step along one ray, signed.
struct EnergyTrace {
    const IntegratorInfo* info = nullptr;
    double step = 0;                            ///< of adaptive methods: the tolerance
    double gradients = 0;                       ///< per ray of the sample
    std::vector<std::array<double, 2>> points;  ///< parameter of H, relative H − H0
};

EnergyTrace energy_trace(const Plan& plan, const Variant& variant, const RayStart& ray);

}  // namespace kagero
