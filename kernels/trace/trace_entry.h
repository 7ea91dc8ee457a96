/// The entries of the tracing loop: declarations alone, since the loop takes long to compile.
#pragma once

#include "kernels/formula/programs.h"
#include "kernels/trace/packets.h"
#include "kernels/trace/registry.h"

namespace kagero {

/// Whether these parameters leave every ray straight.
bool is_straight(std::uint32_t hamiltonian, const double* parameters);

/// The kernel of a job's Hamiltonian.
template <class V>
const SpaceKernel<V>& space_of(const Job& job) {
    using Lookup = const SpaceKernel<V>& (*)(const Job&);
    static constexpr Lookup kernels[] = {
#define KAGERO_HAMILTONIAN(TYPE) \
    [](const Job& j) -> const SpaceKernel<V>& { return space_kernel<hamiltonians::TYPE, V>(j.rescaled); },
#include "hamiltonians.inc"
#undef KAGERO_HAMILTONIAN
        [](const Job& j) -> const SpaceKernel<V>& {
            return formula::space_kernel<V>(formula::programs_in(j.parameters));
        },
    };
    return kernels[job.hamiltonian](job);
}

/// Traces a tile of a job with the kernel of its Hamiltonian, the rays of one packet in lockstep. `KernelInfo::trace`
/// points to this, or to `gang_entry`.
template <class V>
void trace_entry(const Job* job, const Tile* tile, RayEnd* ends, Counters* counters);

/// The same with `lanes` rays in lockstep, which are several packets.
template <class V, int lanes>
void gang_entry(const Job* job, const Tile* tile, RayEnd* ends, Counters* counters);

/// Traces a tile with a kernel, packet by packet.
template <class V>
void trace_with(const SpaceKernel<V>& kernel, const Job& job, const Tile& tile, RayEnd* ends, Counters& counters);

}  // namespace kagero
