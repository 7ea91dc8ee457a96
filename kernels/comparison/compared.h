/// The ways of tracing that exist to be compared with the usual ones: one ray per vector, packets of other widths, and
/// scalar code as the compiler vectorizes it. Each is a value type for the same loop and a `SpaceKernel` for the same
/// methods; they are compiled for the short list of Hamiltonians in kernels/CMakeLists.txt.
#pragma once

#include "kernels/comparison/forward.h"
#include "kernels/methods/space_kernel.h"
#include "kernels/trace/packets.h"
#include "kernels/trace/registry.h"

namespace kagero {

/// One ray, the components of its gradient in the lanes.
struct PerRayGradient {
    using Value = double;
    static constexpr Strategy strategy = Strategy::per_ray;
    static constexpr Form form = Form::gradient;
    static constexpr int registers = ValueTraits<Packed<double, phase_size>>::registers;
};
/// One ray, the stages of a Gauss method in the lanes.
struct PerRayStages {
    using Value = double;
    static constexpr Strategy strategy = Strategy::per_ray;
    static constexpr Form form = Form::stages;
    static constexpr int registers = ValueTraits<Packed<double, max_stages>>::registers;
};
/// The scalar strategy with the compiler's vectorizers on.
struct AutoVectorized {
    using Value = double;
    static constexpr Strategy strategy = Strategy::scalar;
    static constexpr Form form = Form::auto_vectorized;
    static constexpr int registers = 1;
};
/// Packets of `count` registers per variable.
template <class S, int count>
struct OtherWidth {
    using Value = Lanes<S, count>;
    static constexpr Strategy strategy = Strategy::packet;
    static constexpr Form form = Form::none;
    static constexpr int registers = count;
};
/// Packets of the two other numbers of registers among 1, 2 and 4; packets.h has chosen one.
template <class Packet, class S = ScalarOf<Packet>, int chosen = ValueTraits<Packet>::registers>
using Few = OtherWidth<S, chosen == 1 ? 2 : 1>;
template <class Packet, class S = ScalarOf<Packet>, int chosen = ValueTraits<Packet>::registers>
using Many = OtherWidth<S, chosen == 4 ? 2 : 4>;
using FewDouble = Few<PacketDouble>;
using ManyDouble = Many<PacketDouble>;
using FewFloat = Few<PacketFloat>;
using ManyFloat = Many<PacketFloat>;

/// Calls a macro with every way, in the order in which `kagero list strategies` shows them.
#define KAGERO_WAYS(X) \
    X(PerRayStages) X(PerRayGradient) X(AutoVectorized) X(FewDouble) X(ManyDouble) X(FewFloat) X(ManyFloat)

/// Whether a Hamiltonian is on the short list.
template <class H>
inline constexpr bool is_compared = false;
#define KAGERO_HAMILTONIAN(TYPE) \
    template <>                  \
    inline constexpr bool is_compared<hamiltonians::TYPE> = true;
#include "compared.inc"
#undef KAGERO_HAMILTONIAN

/// Defined in one translation unit per way and Hamiltonian of the short list.
template <class Way, class H>
const SpaceKernel<typename Way::Value>& compared_kernel(bool rescaled);

template <class Way>
void trace_compared(const Job*, const Tile*, RayEnd*, Counters*);
template <class Way>
const char* compared_refusal(std::uint32_t hamiltonian, std::uint32_t integrator, bool rescaled, bool straight);

template <class Way>
constexpr KernelInfo compared_kernel_of() {
    using V = typename Way::Value;
    constexpr Precision precision = sizeof(ScalarOf<V>) == sizeof(double) ? Precision::float64 : Precision::float32;
    return {Way::strategy,        precision, Way::form, lane_count<V>, Way::registers, trace_compared<Way>,
            compared_refusal<Way>};
}

}  // namespace kagero
