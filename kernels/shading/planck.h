/// Integrals of Planck's law.
#pragma once

#include "kernels/shading.h"
#include "kernels/simd/lane_memory.h"

namespace kagero::shading {

/// Computes the sums of the temperatures i, i + 1 and so on, one in each lane. The nodes are equidistant, so a
/// recurrence gives m(x) = e^x − 1: m(x + d) = m(x) + m(d) (m(x) + 1). Four recurrences with four times the distance
/// are independent of each other.
template <class V>
void compute_planck_sums(const PlanckSums& planck, std::uint32_t i) {
    constexpr std::uint32_t group = 4;
    const V one(1.0), inverse = one / lanes_of<V>(planck.kelvin + i);
    const auto exponential = [&](double node) { return exp(V(node) * inverse) - one; };
    const V m_step = exponential(group * planck.step);
    V m[group], sums[3] = {V(0.0), V(0.0), V(0.0)};
    for (std::uint32_t k = 0; k < group; ++k) m[k] = exponential(planck.first + k * planck.step);
    for (std::uint32_t node = 0; node < planck.nodes; node += group)
        for (std::uint32_t k = 0; k < group; ++k) {
            const V law = one / m[k];
            for (int c = 0; c < 3; ++c) sums[c] = fma(law, V(planck.weights[c][node + k]), sums[c]);
            m[k] = fma(m_step, m[k] + one, m[k]);
        }
    for (int c = 0; c < 3; ++c) to_doubles(sums[c], planck.sums[c] + i);
}

}  // namespace kagero::shading
