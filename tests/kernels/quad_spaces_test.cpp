// Instantiates the kernels of all Hamiltonians in quadruple precision for all kernel tests. Also compares their steps
// with steps in double.

#include "tests/kernels/steps.h"

#include "kernels/integrators/shared_steps.h"
#include "kernels/methods/steppers.h"

namespace kagero {

// The kernels in double are instantiated in the kernel module.
#define KAGERO_HAMILTONIAN(TYPE)                                                              \
    template const SpaceKernel<Quad>& space_kernel<hamiltonians::TYPE, Quad>(bool);            \
    extern template const SpaceKernel<double>& space_kernel<hamiltonians::TYPE, double>(bool);
#include "hamiltonians.inc"
#undef KAGERO_HAMILTONIAN
template struct SharedSolvers<Quad>;
KAGERO_SHARED_STEPPERS(Quad)

namespace test {
namespace {

template <class H>
class QuadSpaces : public ::testing::Test {};
TYPED_TEST_SUITE(QuadSpaces, AllHamiltonians, HamiltonianName);

TEST(Quad, SquareRootsAreAccurateToRounding) {
    Random random(1);
    for (int i = 0; i < 100; ++i) {
        const Quad x = std::exp(random(-40, 40)), r = sqrt(x);
        EXPECT_LE(static_cast<double>(abs(r * r - x) / (x * machine_epsilon<Quad>)), 4);
    }
}

// One step in quadruple precision and in double. The tolerance allows 100 rounding errors of double, as many as the
// longest method makes.
TYPED_TEST(QuadSpaces, StepsMatchDoubleToRounding) {
    using H = TypeParam;
    for_all_methods<H>([](const Method& method, bool rescaled) {
        const double h = path_length<H> / 32;
        auto in_quad = SpaceStepper<Quad>::for_space<H>(method, rescaled);
        auto in_double = SpaceStepper<double>::for_space<H>(method, rescaled);
        in_quad.begin(state_of<Quad>(bent_ray<H>()), Quad(h));
        in_double.begin(state_of<double>(bent_ray<H>()), h);
        in_quad.step();
        in_double.step();
        EXPECT_TRUE(in_quad.state.solved && in_double.state.solved);
        for (int k = 0; k < 6; ++k) {
            const double y = static_cast<double>(in_quad.state.end.y[k]);
            EXPECT_NEAR(in_double.state.end.y[k], y, 100 * machine_epsilon<double> * (1 + std::abs(y)));
        }
    });
}

}  // namespace
}  // namespace test
}  // namespace kagero
