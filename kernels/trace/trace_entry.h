/// Declarations of the entry functions of the tracing loop. The definitions are separate because the loop takes long to
/// compile.
#pragma once

#include "kernels/formula/programs.h"
#include "kernels/trace/packets.h"
#include "kernels/trace/registry.h"

namespace kagero {

/// Returns true if every ray is straight with these parameters.
bool is_straight(std::uint32_t hamiltonian, const double* parameters);

/// Returns true for the index of the Hamiltonian `formula`.
constexpr bool is_formula(std::uint32_t hamiltonian) {
    constexpr std::uint32_t built_in = 0
#define KAGERO_HAMILTONIAN(TYPE) +1
#include "hamiltonians.inc"
#undef KAGERO_HAMILTONIAN
        ;
    return hamiltonian == built_in;
}

/// Returns the kernel of the job's Hamiltonian.
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

/// Traces a tile of a job with the kernel of its Hamiltonian, packet by packet. `KernelInfo::trace` points to this
/// function or to `gang_entry`.
template <class V>
void trace_entry(const Job* job, const Tile* tile, RayEnd* ends, Counters* counters);

/// Traces a tile of a job by gangs: several packets, with `lanes` lanes in total, perform their steps in turn.
template <class V, int lanes>
void gang_entry(const Job* job, const Tile* tile, RayEnd* ends, Counters* counters);

/// Traces a tile with the given kernel, packet by packet. `straight` is true if every ray is straight.
template <class V>
void trace_with(const SpaceKernel<V>& kernel, bool straight, const Job& job, const Tile& tile, RayEnd* ends,
                Counters& counters);

}  // namespace kagero
