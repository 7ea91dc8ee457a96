/// The entry of the tracing loop behind `KernelInfo::trace`: looks up Hamiltonian and method, then runs the tile.
#pragma once

#include "kernels/formula/programs.h"
#include "kernels/tracing/loop.h"
#include "kernels/tracing/packets.h"
#include "kernels/tracing/registry.h"

namespace kagero {

/// Whether these parameters leave every ray straight.
bool is_straight(std::uint32_t hamiltonian, const double* parameters);

/// Traces a tile, packet by packet.
template <class V>
void trace_tile(const Task<V>& task, const Tile& tile, RayEnd* ends, Counters& counters) {
    RayQueue<lane_count<V>> queue(task.job, tile, ends);
    while (!queue.empty()) PacketTracer<V>(task, counters).trace(queue);
}

/// Traces a tile with the kernel of a Hamiltonian.
template <class V>
void trace_with(const SpaceKernel<V>& kernel, const Job& job, const Tile& tile, RayEnd* ends, Counters& counters) {
    const Task<V> task(job, kernel, is_straight(job.hamiltonian, job.parameters));
    trace_tile(task, tile, ends, counters);
}

/// The kernel of a job's Hamiltonian.
template <class V>
const SpaceKernel<V>& space_of(const Job& job) {
    using Lookup = const SpaceKernel<V>& (*)(const Job&);
    static constexpr Lookup kernels[] = {
#define KAGERO_HAMILTONIAN(TYPE) [](const Job& j) -> const SpaceKernel<V>& { return space_kernel<hamiltonians::TYPE, V>(j.rescaled); },
#include "hamiltonians.inc"
#undef KAGERO_HAMILTONIAN
        [](const Job& j) -> const SpaceKernel<V>& { return formula::space_kernel<V>(formula::programs_in(j.parameters)); },
    };
    return kernels[job.hamiltonian](job);
}

template <class V>
void trace_entry(const Job* job, const Tile* tile, RayEnd* ends, Counters* counters) {
    trace_with(space_of<V>(*job), *job, *tile, ends, *counters);
}

}  // namespace kagero
