// From an index in the list of Hamiltonians to the kernels that are compared: those of the short list.
#include "kernels/comparison/compared.h"
#include "kernels/trace/trace_entry.h"

namespace kagero {

namespace {

/// Null for a Hamiltonian that is not on the short list.
template <class Way>
const SpaceKernel<typename Way::Value>* find_kernel(std::uint32_t hamiltonian, bool rescaled) {
    using Kernel = SpaceKernel<typename Way::Value>;
    using Lookup = const Kernel* (*)(bool);
    static constexpr Lookup kernels[] = {
#define KAGERO_HAMILTONIAN(TYPE)                                                                                             \
    []([[maybe_unused]] bool with_rescaling) -> const Kernel* {                                                              \
        if constexpr (is_compared<hamiltonians::TYPE>) return &compared_kernel<Way, hamiltonians::TYPE>(with_rescaling);     \
        else return nullptr;                                                                                                 \
    },
#include "hamiltonians.inc"
#undef KAGERO_HAMILTONIAN
        [](bool) -> const Kernel* { return nullptr; },  // `formula`
    };
    return kernels[hamiltonian](rescaled);
}

constexpr const char* short_list = "it is compiled for a few spaces alone: "
#include "compared_names.inc"
    ;

}  // namespace

template <class Way>
void trace_compared(const Job* job, const Tile* tile, RayEnd* ends, Counters* counters) {
    trace_with(*find_kernel<Way>(job->hamiltonian, job->rescaled), *job, *tile, ends, *counters);
}

template <class Way>
const char* compared_refusal(std::uint32_t hamiltonian, std::uint32_t integrator, bool rescaled, bool straight) {
    const auto* kernel = find_kernel<Way>(hamiltonian, rescaled);
    if (!kernel) return short_list;
    return straight ? nullptr : kernel->refusal[static_cast<int>(methods[integrator].kind)];
}

#define KAGERO_WAY(WAY)                                                                  \
    template void trace_compared<WAY>(const Job*, const Tile*, RayEnd*, Counters*);      \
    template const char* compared_refusal<WAY>(std::uint32_t, std::uint32_t, bool, bool);
KAGERO_WAYS(KAGERO_WAY)
#undef KAGERO_WAY

}  // namespace kagero
