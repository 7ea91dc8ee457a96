/// The entry of the tracing loop behind `KernelInfo::trace`: looks up Hamiltonian and method, then runs the tile.
#pragma once

#include "kernels/formula/programs.h"
#include "kernels/tracing/loop.h"
#include "kernels/tracing/packets.h"
#include "kernels/tracing/registry.h"

namespace kagero {

/// Whether these parameters leave every ray straight.
bool is_straight(std::uint32_t hamiltonian, const double* parameters);

/// Traces a tile in packets: blocks of pixels aligned to the picture's grid (so that tiles and crops change no packet), or runs of a list.
template <class V>
void trace_tile(const Task<V>& task, const Tile& tile, RayEnd* ends, Counters& counters) {
    constexpr int W = lane_count<V>;
    constexpr std::uint32_t wide = W >= 64 ? 8 : W >= 16 ? 4 : W >= 4 ? (W >= 8 ? 4 : 2) : W, high = W / wide;
    const Job& job = task.job;
    const bool blocks = job.camera && !job.scanlines;
    const std::uint32_t bw = blocks ? wide : W, bh = blocks ? high : 1;
    const std::uint32_t width = tile.x1 - tile.x0;
    for (std::uint32_t by = tile.y0 / bh * bh; by < tile.y1; by += bh) {
        for (std::uint32_t bx = tile.x0 / bw * bw; bx < tile.x1; bx += bw) {
            RayStart starts[W];
            RayEnd* to[W];
            std::uint64_t numbers[W];
            std::uint64_t lanes = 0;
            for (std::uint32_t i = 0; i < W; ++i) {
                const std::uint32_t x = bx + i % bw, y = by + i / bw;
                if (x < tile.x0 || x >= tile.x1 || y < tile.y0 || y >= tile.y1) continue;
                starts[i] = job.camera ? camera_ray(*job.camera, x, y) : job.rays[x];
                to[i] = ends + std::size_t(y - tile.y0) * width + (x - tile.x0);
                numbers[i] = job.camera ? std::uint64_t(y) * job.camera->width + x : x;
                lanes |= std::uint64_t(1) << i;
            }
            if (lanes) PacketTracer<V>(task, counters).trace(starts, lanes, to, numbers);
        }
    }
}

/// Traces a tile with the kernel of a Hamiltonian.
template <class V>
void trace_with(const SpaceKernel<V>& kernel, const Job& job, const Tile& tile, RayEnd* ends, Counters& counters) {
    const Task<V> task(job, kernel, is_straight(job.hamiltonian, job.parameters));
    trace_tile(task, tile, ends, counters);
}

template <class V>
void trace_entry(const Job* job, const Tile* tile, RayEnd* ends, Counters* counters) {
    using Lookup = const SpaceKernel<V>& (*)(const Job&);
    static constexpr Lookup kernels[] = {
#define KAGERO_HAMILTONIAN(TYPE) [](const Job& j) -> const SpaceKernel<V>& { return space_kernel<hamiltonians::TYPE, V>(j.rescaled); },
#include "hamiltonians.inc"
#undef KAGERO_HAMILTONIAN
        [](const Job& j) -> const SpaceKernel<V>& { return formula::space_kernel<V>(formula::programs_in(j.parameters)); },
    };
    trace_with(kernels[job->hamiltonian](*job), *job, *tile, ends, *counters);
}

}  // namespace kagero
