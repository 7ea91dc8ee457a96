// Benchmarks of gradient.h for packets: with the registers per variable that kagero uses, with one, and with four.
#include "bench/kernels/gradient.h"
#include "kernels/trace/packets.h"

namespace {

const bool added = [] {
    using namespace kagero;
    bench::add_gradients<PacketDouble>("packet_double");
    bench::add_gradients<PacketFloat>("packet_float");
    bench::add_gradients<Lanes<double, 1>>("one_register_double");
    bench::add_gradients<Lanes<float, 1>>("one_register_float");
    bench::add_gradients<Lanes<double, 4>>("four_registers_double");
    return true;
}();

}  // namespace
