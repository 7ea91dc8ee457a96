// Every Hamiltonian on quadruple precision, compiled once for all tests that need it.

#include "tests/kernels/steps.h"

#include "kernels/integrators/shared_steps.h"
#include "kernels/methods/steppers.h"

namespace kagero {

// Those on double are compiled elsewhere.
#define KAGERO_HAMILTONIAN(TYPE)                                                              \
    template const SpaceKernel<Quad>& space_kernel<hamiltonians::TYPE, Quad>(bool);            \
    extern template const SpaceKernel<double>& space_kernel<hamiltonians::TYPE, double>(bool);
#include "hamiltonians.inc"
#undef KAGERO_HAMILTONIAN
template struct Shared<Quad>;
KAGERO_SHARED_STEPPERS(Quad)

namespace test {
namespace {

template <class H>
class QuadSpaces : public ::testing::Test {};
TYPED_TEST_SUITE(QuadSpaces, AllHamiltonians, HamiltonianName);

TEST(Quad, SquareRootsAreExactToTheLastDigits) {
    Random random(1);
    for (int i = 0; i < 100; ++i) {
        const Quad x = std::exp(random(-40, 40)), r = sqrt(x);
        EXPECT_LE(static_cast<double>(abs(r * r - x) / (x * machine_epsilon<Quad>)), 4);
    }
}

// A step in quadruple precision is the step in double without its rounding errors: a few for every operation of the
// longest method.
TYPED_TEST(QuadSpaces, StepsAreThoseOfDoubleWithoutItsRounding) {
    using H = TypeParam;
    for_all_methods<H>([](const Method& method, bool rescaled) {
        const double h = path_length<H> / 32;
        auto exact = Steps<Quad>::in<H>(method, rescaled);
        auto rounded = Steps<double>::in<H>(method, rescaled);
        exact.begin(state_of<Quad>(bent_ray<H>()), Quad(h));
        rounded.begin(state_of<double>(bent_ray<H>()), h);
        exact.step(), rounded.step();
        EXPECT_TRUE(exact.flow.solved && rounded.flow.solved);
        for (int k = 0; k < 6; ++k) {
            const double y = static_cast<double>(exact.flow.end.y[k]);
            EXPECT_NEAR(rounded.flow.end.y[k], y, 100 * machine_epsilon<double> * (1 + std::abs(y)));
        }
    });
}

}  // namespace
}  // namespace test
}  // namespace kagero
