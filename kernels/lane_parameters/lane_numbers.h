/// The parameters of the rays in the lanes of a packet, and the kernels that use them.
#pragma once

#include "kernels/methods/space_kernel.h"
#include "kernels/trace/packets.h"

namespace kagero {

/// The numbers from which a LaneSystem is constructed: one per lane for each parameter of H, then the lanes' numbers of
/// ParameterSet::capture_radius and of ParameterSet::capture_stretch.
template <class V>
struct LaneNumbers {
    static constexpr int max_parameters = 16;
    alignas(64) double numbers[max_parameters + 2][lane_count<V>];

    /// Writes the numbers of a Hamiltonian with `parameter_count` parameters.
    LaneNumbers(const ParameterSet* const* sets, int parameter_count) {
        for (int i = 0; i < lane_count<V>; ++i) {
            for (int k = 0; k < parameter_count; ++k) numbers[k][i] = sets[i]->parameters[k];
            numbers[parameter_count][i] = sets[i]->capture_radius;
            numbers[parameter_count + 1][i] = sets[i]->capture_stretch;
        }
    }
};

/// Returns the kernel of the Hamiltonian for lanes with different parameters. It is defined in one translation
/// unit per Hamiltonian.
template <class H>
const SpaceKernel<PacketDouble>& lane_kernel();

}  // namespace kagero
