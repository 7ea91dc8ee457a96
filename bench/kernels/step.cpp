// Question: how long does one step of each method take per ray, in each space?
#include "bench/kernels/steps.h"
#include "all_hamiltonians.inc"

namespace kagero {
namespace {

template <class H, class V>
void add(const char* type) {
    for (const bool rescaled : {false, true}) {
        if (rescaled && !Rescalable<H>) continue;
        for (const Method& method : methods) {
            if (space_kernel<H, V>(rescaled).refusal[static_cast<int>(method.kind)]) continue;
            const std::string path =
                std::string("step/") + H::name + (rescaled ? "_rescaled/" : "/") + method.info.name + "/" + type;
            benchmark::RegisterBenchmark(path.c_str(), [&method, rescaled](benchmark::State& state) {
                bench::measure_steps<H, V>(state, method, space_kernel<H, V>(rescaled));
            });
        }
    }
}

const bool added = [] {
#define KAGERO_HAMILTONIAN(TYPE)                             \
    add<hamiltonians::TYPE, PacketDouble>("packet_double");  \
    add<hamiltonians::TYPE, PacketFloat>("packet_float");    \
    add<hamiltonians::TYPE, double>("double");               \
    add<hamiltonians::TYPE, float>("float");
#include "hamiltonians.inc"
#undef KAGERO_HAMILTONIAN
    return true;
}();

}  // namespace
}  // namespace kagero
