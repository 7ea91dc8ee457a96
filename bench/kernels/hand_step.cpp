// What does automatic differentiation cost in a whole step? The steps of `verlet` and `gauss8` on (16), K = r·H, with
// derivatives worked out by hand in the place of the tape's, and with the tape's of (16) as it is printed, term by term
// (which finds the square in it); all else is the same code.
#include "bench/kernels/gradient_rivals.h"
#include "bench/kernels/printed_schwarzschild.h"
#include "bench/kernels/steps.h"
#include "kernels/methods/steppers.h"

namespace kagero {

using hamiltonians::Schwarzschild;
// The tape's on the module's own packets are those of the module.
extern template const SpaceKernel<PacketDouble>& space_kernel<Schwarzschild, PacketDouble>(bool);
extern template const SpaceKernel<PacketFloat>& space_kernel<Schwarzschild, PacketFloat>(bool);

namespace {

template <class S>
struct HandSystem : System<Schwarzschild, true, S> {
    S rg;
    explicit HandSystem(const double* parameters) : System<Schwarzschild, true, S>(parameters), rg(S(parameters[0])) {}

    template <class V>
    KAGERO_INLINE void derivatives(const State<V>& s, V* out) const { bench::Hand<V, true>(rg).derivatives(s, out); }
    template <class V>
    KAGERO_INLINE Vec3<V> dq(const State<V>& s) const { return bench::Hand<V, true>(rg).dq(s); }
    template <class V>
    KAGERO_INLINE Vec3<V> dp(const State<V>& s) const { return bench::Hand<V, true>(rg).dp(s); }
};

template <class Rival, class V>
constexpr SpaceKernel<V> rival_kernel = [] {
    SpaceKernel<V> kernel = detail::kernel_without_steps<Rival, V>();
    detail::add_step<Rival, Composition>(kernel, static_cast<int>(Kind::composition));
    detail::add_step<Rival, Gauss<4>>(kernel, static_cast<int>(Kind::gauss_of_4));
    return kernel;
}();

template <class V>
void add(const char* form, const char* type, const SpaceKernel<V>& kernel) {
    for (const Method& method : methods) {
        const std::string name = method.info.name;
        if (name != "verlet" && name != "gauss8") continue;
        bench::require_same_step<Schwarzschild>(method, kernel, space_kernel<Schwarzschild, V>(true));
        benchmark::RegisterBenchmark((std::string("step/schwarzschild_") + form + "/" + name + "/" + type).c_str(),
                                     [&method, &kernel](benchmark::State& state) {
                                         bench::steps<Schwarzschild, V>(state, method, kernel);
                                     });
    }
}

template <class V>
void add(const char* type) {
    add<V>("by_hand", type, rival_kernel<HandSystem<ScalarOf<V>>, V>);
    add<V>("as_printed", type, rival_kernel<System<bench::PrintedSchwarzschild, true, ScalarOf<V>>, V>);
}

const bool added = [] {
    add<PacketDouble>("packet_double");
    add<PacketFloat>("packet_float");
    add<Lanes<double, 1>>("one_register_double");
    return true;
}();

}  // namespace
}  // namespace kagero
