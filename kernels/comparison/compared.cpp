// Dispatch from the index of a Hamiltonian in Module::hamiltonians to its kernel for a vectorization.
#include "kernels/comparison/compared.h"
#include "kernels/trace/trace_entry.h"

namespace kagero {

namespace {

/// Returns the kernel of a formula, or of a compared Hamiltonian with or without time rescaling. `hamiltonian` is its
/// index. The result is nullptr for other Hamiltonians, and for formulas if the vectorization does not exist for them.
template <class Vectorization>
const SpaceKernel<typename Vectorization::Value>* find_kernel(std::uint32_t hamiltonian, const double* parameters,
                                                              bool rescaled) {
    using Kernel = SpaceKernel<typename Vectorization::Value>;
    using GetKernel = const Kernel* (*)(const double*, bool);
    static constexpr GetKernel kernels[] = {
#define KAGERO_HAMILTONIAN(TYPE)                                                                  \
    [](const double*, [[maybe_unused]] bool with_rescaling) -> const Kernel* {                    \
        if constexpr (is_compared<hamiltonians::TYPE>)                                            \
            return &compared_kernel<Vectorization, hamiltonians::TYPE>(with_rescaling);           \
        else return nullptr;                                                                      \
    },
#include "hamiltonians.inc"
#undef KAGERO_HAMILTONIAN
        []([[maybe_unused]] const double* programs, bool) -> const Kernel* {
            if constexpr (Vectorization::form == Form::auto_vectorized) return nullptr;
            else return &compared_formula_kernel<Vectorization>(formula::programs_in(programs));
        },
    };
    return kernels[hamiltonian](parameters, rescaled);
}

constexpr const char* not_compiled = "this kernel is compiled only for these spaces: "
#include "compared_names.inc"
    ;

/// Returns nullptr if a vectorization can use the programs of a formula, else the reason why not.
template <class Vectorization>
const char* refusal_of_programs(const formula::Programs& programs) {
    if (Vectorization::form == Form::auto_vectorized) return "no compiler vectorizes the code of a formula";
    if (!programs.for_comparison) return not_compiled;
    if (!programs.is_compiled) return "this kernel needs machine code, but the formula is interpreted";
    if (Vectorization::form == Form::gradient)
        for (const formula::ForwardProgram& forward : programs.forward)
            if (forward.size == 0) return "the formula is too large for differentiation in forward mode";
    return nullptr;
}

}  // namespace

template <class Vectorization>
void trace_compared(const Job* job, const Tile* tile, RayEnd* ends, Counters* counters) {
    trace_with(*find_kernel<Vectorization>(job->hamiltonian, job->parameters, job->rescaled),
               is_straight(job->hamiltonian, job->parameters), *job, *tile, ends, *counters);
}

template <class Vectorization>
const char* compared_refusal(const SpaceAndMethod* c) {
    if (is_formula(c->hamiltonian))
        if (const char* reason = refusal_of_programs<Vectorization>(formula::programs_in(c->parameters))) return reason;
    const auto* kernel = find_kernel<Vectorization>(c->hamiltonian, c->parameters, c->rescaled);
    if (!kernel) return not_compiled;
    return c->straight ? nullptr : kernel->refusal[static_cast<int>(methods[c->integrator].kind)];
}

#define KAGERO_VECTORIZATION(VECTORIZATION)                                                      \
    template void trace_compared<VECTORIZATION>(const Job*, const Tile*, RayEnd*, Counters*);    \
    template const char* compared_refusal<VECTORIZATION>(const SpaceAndMethod*);
KAGERO_VECTORIZATIONS(KAGERO_VECTORIZATION)
#undef KAGERO_VECTORIZATION

}  // namespace kagero
