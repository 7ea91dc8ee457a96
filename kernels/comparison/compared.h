/// Vectorizations that exist only for comparison with the default kernels: one ray per vector, packets of other widths,
/// and scalar code that the compiler vectorizes.
///
/// A vectorization is a struct that defines how lanes are used. It contains the value type of the tracing loop, the
/// strategy and its form as in `kagero list strategies`, and the number of registers per variable. Its kernels are
/// compiled only for the Hamiltonians in `compared_hamiltonians` (kernels/CMakeLists.txt), here called compared
/// Hamiltonians, and for formulas, which are machine code. Other Hamiltonians are compared by the programs of a formula
/// that are recorded from them at run time (Formula::for_comparison).
#pragma once

#include "kernels/comparison/forward.h"
#include "kernels/formula/programs.h"
#include "kernels/methods/space_kernel.h"
#include "kernels/trace/packets.h"
#include "kernels/trace/registry.h"

namespace kagero {

/// Traces one ray at a time. The lanes hold the components of the gradient of K.
struct PerRayGradient {
    using Value = double;
    static constexpr Strategy strategy = Strategy::per_ray;
    static constexpr Form form = Form::gradient;
    static constexpr int registers = ValueTraits<Packed<double, phase_size>>::registers;
};
/// Traces one ray at a time. The lanes hold the stages of a Gauss method.
struct PerRayStages {
    using Value = double;
    static constexpr Strategy strategy = Strategy::per_ray;
    static constexpr Form form = Form::stages;
    static constexpr int registers = ValueTraits<Packed<double, max_stages>>::registers;
};
/// Traces one ray at a time with scalar code, for which the compiler's vectorizers are enabled.
struct AutoVectorized {
    using Value = double;
    static constexpr Strategy strategy = Strategy::scalar;
    static constexpr Form form = Form::auto_vectorized;
    static constexpr int registers = 1;
};
/// Traces packets of rays with `count` registers per variable.
template <class S, int count>
struct PacketOfRegisters {
    using Value = Lanes<S, count>;
    static constexpr Strategy strategy = Strategy::packet;
    static constexpr Form form = Form::none;  // the packet strategy itself, without its form `gang`
    static constexpr int registers = count;
};
/// Packets have 1, 2 or 4 registers per variable. One of these numbers is the default (packets.h). `SmallerAlternative`
/// has the smaller of the two other numbers, and `LargerAlternative` the larger one.
template <class Packet, class S = ScalarOf<Packet>, int default_registers = ValueTraits<Packet>::registers>
using SmallerAlternative = PacketOfRegisters<S, default_registers == 1 ? 2 : 1>;
template <class Packet, class S = ScalarOf<Packet>, int default_registers = ValueTraits<Packet>::registers>
using LargerAlternative = PacketOfRegisters<S, default_registers == 4 ? 2 : 4>;
using SmallerAlternativeDouble = SmallerAlternative<PacketDouble>;
using LargerAlternativeDouble = LargerAlternative<PacketDouble>;
using SmallerAlternativeFloat = SmallerAlternative<PacketFloat>;
using LargerAlternativeFloat = LargerAlternative<PacketFloat>;

/// Expands X(vectorization) for every vectorization, in the order in which `kagero list strategies` shows them.
#define KAGERO_VECTORIZATIONS(X)                                                                               \
    X(PerRayStages) X(PerRayGradient) X(AutoVectorized) X(SmallerAlternativeDouble) X(LargerAlternativeDouble) \
    X(SmallerAlternativeFloat) X(LargerAlternativeFloat)

/// True if H is a compared Hamiltonian.
template <class H>
inline constexpr bool is_compared = false;
#define KAGERO_HAMILTONIAN(TYPE) \
    template <>                  \
    inline constexpr bool is_compared<hamiltonians::TYPE> = true;
#include "compared.inc"
#undef KAGERO_HAMILTONIAN

/// Returns the kernel of a compared Hamiltonian, with or without time rescaling. This function is defined in
/// compared_kernel.h and instantiated in files that kernels/CMakeLists.txt generates from compared_space.cpp.in.
template <class Vectorization, class H>
const SpaceKernel<typename Vectorization::Value>& compared_kernel(bool rescaled);

/// Returns the kernel of a formula. This function is defined in compared_formula.h and instantiated in files that
/// kernels/CMakeLists.txt generates from compared_formula.cpp.in.
template <class Vectorization>
const SpaceKernel<typename Vectorization::Value>& compared_formula_kernel(const formula::Programs& programs);

/// Traces a tile of rays with the kernel of this vectorization. Implements KernelInfo::trace.
template <class Vectorization>
void trace_compared(const Job*, const Tile*, RayEnd*, Counters*);
/// Returns nullptr if the kernel of this vectorization supports the space and the method, else the reason why not.
/// Implements KernelInfo::refusal.
template <class Vectorization>
const char* compared_refusal(const SpaceAndMethod* combination);

/// Returns the entry of a vectorization in the list Module::kernels.
template <class Vectorization>
constexpr KernelInfo compared_kernel_info() {
    using V = typename Vectorization::Value;
    constexpr Precision precision = sizeof(ScalarOf<V>) == sizeof(double) ? Precision::float64 : Precision::float32;
    return {Vectorization::strategy,  precision,
            Vectorization::form,      lane_count<V>,
            Vectorization::registers, trace_compared<Vectorization>,
            compared_refusal<Vectorization>};
}

}  // namespace kagero
