// Question: how much longer is a step with automatic differentiation than with hand-written derivatives? Measures steps
// of `verlet` and `gauss8` for K = r·H, with H of equation (16) of Satoh (2003). `by_hand` uses hand-written
// derivatives. `as_printed` differentiates H term by term as printed. Several of its terms form the square
// (p_r + p_t)², which kagero must then find in the recorded operations. All other code is the same as in `step.cpp`.
#include "bench/kernels/gradient_methods.h"
#include "bench/kernels/printed_schwarzschild.h"
#include "bench/kernels/steps.h"
#include "kernels/methods/steppers.h"

namespace kagero {

using hamiltonians::Schwarzschild;
// These kernels are compiled in the object files of the kernel module.
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
    KAGERO_INLINE Vec3<V> gradient_q(const State<V>& s) const { return bench::HandWritten<V, true>(rg).gradient_q(s); }
    template <class V>
    KAGERO_INLINE Vec3<V> gradient_p(const State<V>& s) const { return bench::HandWritten<V, true>(rg).gradient_p(s); }
};

/// The kernel of a system with the steppers of `verlet` and `gauss8`.
template <class System, class V>
constexpr SpaceKernel<V> kernel_of = [] {
    SpaceKernel<V> kernel = detail::kernel_for_straight_rays<System, V>();
    detail::add_step<System, Composition>(kernel, static_cast<int>(StepperKind::composition));
    detail::add_step<System, Gauss<4>>(kernel, static_cast<int>(StepperKind::gauss_4_stages));
    return kernel;
}();

/// Registers the benchmarks of both methods with a kernel. Ends the program if its steps differ from those of the
/// kernel module.
template <class V>
void add(const char* derivatives, const char* type, const SpaceKernel<V>& kernel) {
    for (const Method& method : methods) {
        const std::string name = method.info.name;
        if (name != "verlet" && name != "gauss8") continue;
        bench::require_same_step<Schwarzschild>(method, kernel, space_kernel<Schwarzschild, V>(true));
        const std::string path = std::string("step/schwarzschild_") + derivatives + "/" + name + "/" + type;
        benchmark::RegisterBenchmark(path.c_str(),
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
