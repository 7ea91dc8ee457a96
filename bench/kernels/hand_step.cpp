// Question: how much longer is a step with automatic differentiation than with hand-written derivatives? Measures steps
// of `verlet` and `gauss8` for K = r·H, with H of equation (16) of Satoh (2003). `by_hand` uses hand-written
// derivatives. `as_printed` differentiates H term by term as printed, where the tape must find the common square
// itself. All other code is the same as in `step.cpp`.
#include "bench/kernels/gradient_methods.h"
#include "bench/kernels/printed_schwarzschild.h"
#include "bench/kernels/steps.h"
#include "kernels/methods/steppers.h"

namespace kagero {

using hamiltonians::Schwarzschild;
// These kernels are already compiled in the module.
extern template const SpaceKernel<PacketDouble>& space_kernel<Schwarzschild, PacketDouble>(bool);
extern template const SpaceKernel<PacketFloat>& space_kernel<Schwarzschild, PacketFloat>(bool);

namespace {

/// The system of K with hand-written derivatives.
template <class S>
struct HandWrittenSystem : System<Schwarzschild, true, S> {
    S rg;
    explicit HandWrittenSystem(const double* parameters)
        : System<Schwarzschild, true, S>(parameters), rg(S(parameters[0])) {}

    template <class V>
    KAGERO_INLINE void derivatives(const State<V>& s, V* out) const {
        bench::HandWritten<V, true>(rg).derivatives(s, out);
    }
    template <class V>
    KAGERO_INLINE Vec3<V> dq(const State<V>& s) const { return bench::HandWritten<V, true>(rg).dq(s); }
    template <class V>
    KAGERO_INLINE Vec3<V> dp(const State<V>& s) const { return bench::HandWritten<V, true>(rg).dp(s); }
};

/// The kernel of a system with the steppers of `verlet` and `gauss8`.
template <class System, class V>
constexpr SpaceKernel<V> kernel_of = [] {
    SpaceKernel<V> kernel = detail::kernel_without_steps<System, V>();
    detail::add_step<System, Composition>(kernel, static_cast<int>(StepperKind::composition));
    detail::add_step<System, Gauss<4>>(kernel, static_cast<int>(StepperKind::gauss_of_4));
    return kernel;
}();

/// Registers the benchmarks of both methods with a kernel. Ends the program if its steps differ from those of the
/// module.
template <class V>
void add(const char* form, const char* type, const SpaceKernel<V>& kernel) {
    for (const Method& method : methods) {
        const std::string name = method.info.name;
        if (name != "verlet" && name != "gauss8") continue;
        bench::require_same_step<Schwarzschild>(method, kernel, space_kernel<Schwarzschild, V>(true));
        benchmark::RegisterBenchmark((std::string("step/schwarzschild_") + form + "/" + name + "/" + type).c_str(),
                                     [&method, &kernel](benchmark::State& state) {
                                         bench::measure_steps<Schwarzschild, V>(state, method, kernel);
                                     });
    }
}

template <class V>
void add(const char* type) {
    add<V>("by_hand", type, kernel_of<HandWrittenSystem<ScalarOf<V>>, V>);
    add<V>("as_printed", type, kernel_of<System<bench::PrintedSchwarzschild, true, ScalarOf<V>>, V>);
}

const bool added = [] {
    add<PacketDouble>("packet_double");
    add<PacketFloat>("packet_float");
    add<Lanes<double, 1>>("one_register_double");
    return true;
}();

}  // namespace
}  // namespace kagero
