// Benchmarks of gradient.h for one ray at a time.
#include "bench/kernels/gradient.h"

namespace {

const bool added = [] {
    kagero::bench::add_gradients<double>("double");
    kagero::bench::add_gradients<float>("float");
    return true;
}();

}  // namespace
