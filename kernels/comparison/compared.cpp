// Dispatch from the index of a Hamiltonian in Module::hamiltonians to its kernel for a vectorization.
#include "kernels/comparison/compared.h"
#include "kernels/trace/trace_entry.h"

namespace kagero {

namespace {

/// Returns the kernel of the Hamiltonian with the index `hamiltonian`, or nullptr if it is not a compared Hamiltonian.
/// `rescaled` selects the kernel with time rescaling.
template <class Vectorization>
const SpaceKernel<typename Vectorization::Value>* find_kernel(std::uint32_t hamiltonian, bool rescaled) {
    using Kernel = SpaceKernel<typename Vectorization::Value>;
    using GetKernel = const Kernel* (*)(bool);
    static constexpr GetKernel kernels[] = {
#define KAGERO_HAMILTONIAN(TYPE)                                                                  \
    []([[maybe_unused]] bool with_rescaling) -> const Kernel* {                                   \
        if constexpr (is_compared<hamiltonians::TYPE>)                                            \
            return &compared_kernel<Vectorization, hamiltonians::TYPE>(with_rescaling);           \
        else return nullptr;                                                                      \
    },
#include "hamiltonians.inc"
#undef KAGERO_HAMILTONIAN
        [](bool) -> const Kernel* { return nullptr; },  // the Hamiltonian `formula` is not compared
    };
    return kernels[hamiltonian](rescaled);
}

constexpr const char* not_compiled = "this kernel is compiled only for these spaces: "
#include "compared_names.inc"
    ;

}  // namespace

template <class Vectorization>
void trace_compared(const Job* job, const Tile* tile, RayEnd* ends, Counters* counters) {
    trace_with(*find_kernel<Vectorization>(job->hamiltonian, job->rescaled),
               is_straight(job->hamiltonian, job->parameters), *job, *tile, ends, *counters);
}

template <class Vectorization>
const char* compared_refusal(std::uint32_t hamiltonian, std::uint32_t integrator, bool rescaled, bool straight) {
    const auto* kernel = find_kernel<Vectorization>(hamiltonian, rescaled);
    if (!kernel) return not_compiled;
    return straight ? nullptr : kernel->refusal[static_cast<int>(methods[integrator].kind)];
}

#define KAGERO_VECTORIZATION(VECTORIZATION)                                                      \
    template void trace_compared<VECTORIZATION>(const Job*, const Tile*, RayEnd*, Counters*);    \
    template const char* compared_refusal<VECTORIZATION>(std::uint32_t, std::uint32_t, bool, bool);
KAGERO_VECTORIZATIONS(KAGERO_VECTORIZATION)
#undef KAGERO_VECTORIZATION

}  // namespace kagero
