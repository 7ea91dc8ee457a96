/// The entry of the tracing loop behind `KernelInfo::trace`: looks up Hamiltonian and method, then runs the tile.
#pragma once

#include "kernels/tracing/loop.h"
#include "kernels/tracing/packets.h"
#include "kernels/tracing/registry.h"

namespace kagero {

/// Whether these parameters leave every ray straight.
bool is_straight(std::uint32_t hamiltonian, const double* parameters);

template <class V>
void trace_entry(const Job* job, const Tile* tile, RayEnd* ends, Counters* counters) {
    using Lookup = const SpaceKernel<V>& (*)(bool);
    static constexpr Lookup kernels[] = {
#define KAGERO_HAMILTONIAN(TYPE) &space_kernel<hamiltonians::TYPE, V>,
#include "hamiltonians.inc"
#undef KAGERO_HAMILTONIAN
    };
    const Task<V> task(*job, kernels[job->hamiltonian](job->rescaled), is_straight(job->hamiltonian, job->parameters));
    trace_tile(task, *tile, ends, *counters);
}

}  // namespace kagero
