#include "kernels/lane_parameters/lane_kernels.h"

#include "all_hamiltonians.inc"
#include "kernels/assertion.h"
#include "kernels/trace/trace_entry.h"

#include <algorithm>

namespace kagero {

template void fill_uniforms<PacketDouble>(const Node*, const int*, int, const PacketDouble*, PacketDouble*);

namespace {

/// A Hamiltonian for lanes with different parameters.
struct LaneSpace {
    const SpaceKernel<PacketDouble>& (*kernel)();
    int parameter_count;
    bool rescaled;  ///< True if the kernel integrates Ω (H − H0).
};
constexpr LaneSpace lane_spaces[] = {
#define KAGERO_HAMILTONIAN(TYPE)                                                               \
    {lane_kernel<hamiltonians::TYPE>, static_cast<int>(hamiltonians::TYPE::parameters.size()), \
     Rescalable<hamiltonians::TYPE>},
#include "hamiltonians.inc"
#undef KAGERO_HAMILTONIAN
};

/// Traces a run of a list of rays, packet by packet. The lanes of a packet have the parameters of their rays; idle
/// lanes have those of the last ray.
void trace_sweep(const Job* job, const Tile* tile, RayEnd* ends, Counters* counters) {
    using V = PacketDouble;
    constexpr std::uint32_t W = lane_count<V>;
    const LaneSpace& space = lane_spaces[job->hamiltonian];
    KAGERO_ASSERT(job->sets && job->set_count > 0 && job->rays && !job->refill && job->rescaled == space.rescaled);
    Job packet_job = *job;
    for (std::uint32_t first = tile->x0; first < tile->x1; first += W) {
        const Tile packet{first, 0, std::min(first + W, tile->x1), 1};
        const ParameterSet* sets[W];
        for (std::uint32_t i = 0; i < W; ++i) sets[i] = &job->sets[std::min(first + i, packet.x1 - 1) % job->set_count];
        const LaneNumbers<V> numbers(sets, space.parameter_count);
        packet_job.parameters = numbers.numbers[0];
        packet_job.lane_sets = sets;
        trace_with(space.kernel(), false, packet_job, packet, ends + (first - tile->x0), *counters);
    }
}

const char* sweep_refusal(std::uint32_t hamiltonian, std::uint32_t integrator, bool rescaled, bool straight) {
    if (hamiltonian >= std::size(lane_spaces)) return "a formula has one program per set of its constants";
    if (straight) return "straight rays are traced in closed form, without lanes of different parameters";
    const LaneSpace& space = lane_spaces[hamiltonian];
    if (rescaled != space.rescaled)
        return "this kernel is compiled only with the time rescaling that the Hamiltonian declares";
    return space.kernel().refusal[static_cast<int>(methods[integrator].kind)];
}

}  // namespace

KernelInfo sweep_kernel_info() {
    return {Strategy::packet,
            Precision::float64,
            Form::none,
            lane_count<PacketDouble>,
            ValueTraits<PacketDouble>::registers,
            trace_sweep,
            sweep_refusal};
}

}  // namespace kagero
