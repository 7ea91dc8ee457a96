// What does automatic differentiation cost in a whole step? The steps of `verlet` and `gauss8` on (16), K = r·H, with derivatives worked out
// by hand in the place of the tape's; all else is the same code.
#include "bench/kernels/gradient_rivals.h"
#include "bench/kernels/steps.h"
#include "kernels/stepping/steppers.h"

namespace kagero {
namespace {

using hamiltonians::Schwarzschild;

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

template <class V>
constexpr SpaceKernel<V> hand_kernel = [] {
    using Hand = HandSystem<ScalarOf<V>>;
    SpaceKernel<V> kernel = detail::kernel_without_steps<Hand, V>();
    const auto add = [&]<class Step>(Kind kind) {
        kernel.begin[static_cast<int>(kind)] = detail::begin<Hand, Step, V>;
        kernel.step[static_cast<int>(kind)] = detail::step<Hand, Step, V>;
    };
    add.template operator()<Composition>(Kind::composition);
    add.template operator()<Gauss<4>>(Kind::gauss_of_4);
    return kernel;
}();

template <class V>
void add(const char* type) {
    for (const Method& method : methods) {
        const std::string name = method.info.name;
        if (name != "verlet" && name != "gauss8") continue;
        benchmark::RegisterBenchmark(("step/schwarzschild_by_hand/" + name + "/" + type).c_str(), [&method](benchmark::State& state) {
            bench::steps<Schwarzschild, V>(state, method, hand_kernel<V>);
        });
    }
}

const bool added = [] {
    add<PacketDouble>("packet_double");
    add<PacketFloat>("packet_float");
    return true;
}();

}  // namespace
}  // namespace kagero
