/// The entry of the tracing loop behind `KernelInfo::trace`: looks up Hamiltonian and method, then runs the tile.
#pragma once

#include "kernels/formula/programs.h"
#include "kernels/tracing/loop.h"
#include "kernels/tracing/packets.h"
#include "kernels/tracing/registry.h"

#include <algorithm>
#include <optional>

namespace kagero {

/// Whether these parameters leave every ray straight.
bool is_straight(std::uint32_t hamiltonian, const double* parameters);

/// Traces a tile, packet by packet, or by gangs: packets that take their steps in turn, so that all wait for the longest ray of them. That
/// is a vector of hundreds of lanes, done a few registers at a time.
template <int packets = 1, class V>
void trace_tile(const Task<V>& task, const Tile& tile, RayEnd* ends, Counters& counters) {
    RayQueue<lane_count<V>> queue(task.job, tile, ends);
    if constexpr (packets == 1) {
        while (!queue.empty()) {
            PacketTracer<V> packet(task, counters);
            packet.start(queue);
            while (packet.goes_on()) packet.step(queue);
            packet.finish();
        }
    } else {
        std::optional<PacketTracer<V>> gang[packets];
        while (!queue.empty()) {
            for (auto& packet : gang) packet.emplace(task, counters), packet->start(queue);
            while (std::any_of(gang, gang + packets, [](const auto& packet) { return packet->goes_on(); }))
                for (auto& packet : gang) packet->goes_on() ? packet->step(queue) : packet->idle();
            for (auto& packet : gang) packet->finish();
        }
    }
}

/// Traces a tile with the kernel of a Hamiltonian.
template <int packets = 1, class V>
void trace_with(const SpaceKernel<V>& kernel, const Job& job, const Tile& tile, RayEnd* ends, Counters& counters) {
    const Task<V> task(job, kernel, is_straight(job.hamiltonian, job.parameters));
    trace_tile<packets>(task, tile, ends, counters);
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

/// Traces a tile with so many rays in lockstep: a packet's, or a gang's.
template <class V, int lanes = lane_count<V>>
void trace_entry(const Job* job, const Tile* tile, RayEnd* ends, Counters* counters) {
    trace_with<lanes / lane_count<V>>(space_of<V>(*job), *job, *tile, ends, *counters);
}

}  // namespace kagero
