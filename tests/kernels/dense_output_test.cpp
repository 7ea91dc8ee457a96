// Measures the order of dense output inside a step. The reference at a point inside the step is the end of a shorter
// step of order 16.
#include "tests/kernels/steps.h"

#include <algorithm>
#include <cmath>

namespace kagero::test {
namespace {

template <class H>
class DenseOutput : public ::testing::Test {};
TYPED_TEST_SUITE(DenseOutput, AllHamiltonians, HamiltonianName);

/// Returns a stepper that has performed one step of length h of a bent ray.
template <class H>
SpaceStepper<Quad> one_step(const std::string& method, bool rescaled, int ray, Quad h) {
    auto stepper = SpaceStepper<Quad>::template for_space<H>(method_named(method), rescaled);
    stepper.begin(state_of<Quad>(bent_ray<H>(ray)), h);
    stepper.step();
    return stepper;
}

/// The errors of dense output at three points inside a step, and the length of the step. Both are sums over the bent
/// rays.
struct CurveError {
    double error = 0, length = 0;
};
/// Returns the error of the dense output `curve_of(state)` inside a step of length h in τ from the start of each bent
/// ray.
template <class H, class CurveOf>
CurveError error_inside(const std::string& method, bool rescaled, Quad h, const CurveOf& curve_of) {
    CurveError sum;
    for (int ray = 0; ray < bent_ray_count; ++ray) {
        const auto stepper = one_step<H>(method, rescaled, ray, h);
        const Curve<Quad> curve = curve_of(stepper.state);
        const auto distance = [](const Vec3<Quad>& a, const Vec3<Quad>& b) {
            return std::sqrt(static_cast<double>(dot(a - b, a - b)));
        };
        EXPECT_EQ(distance(curve.at(Quad(0)), stepper.state.start.q()), 0);
        EXPECT_EQ(distance(curve.at(Quad(1)), stepper.state.end.q()), 0);
        sum.length += distance(stepper.state.start.q(), stepper.state.end.q());
        for (const double s : {0.19, 0.44, 0.78})
            sum.error += distance(curve.at(Quad(s)), one_step<H>("gauss16", rescaled, ray, Quad(s) * h).state.end.q());
    }
    return sum;
}

/// Expects that the error decreases by at least a factor of 2^(order − 1/2) if the step is halved.
template <class H, class CurveOf>
void expect_order(const std::string& method, int order, bool rescaled, const CurveOf& curve_of) {
    SCOPED_TRACE(method + (rescaled ? ", rescaled" : ""));
    const Quad h = Quad(path_length<H>) / 64;
    const CurveError coarse = error_inside<H>(method, rescaled, h, curve_of),
              fine = error_inside<H>(method, rescaled, h / 2, curve_of);
    const double rounding = 1e-30 * coarse.length;
    if (fine.error <= rounding)
        EXPECT_LE(coarse.error, std::ldexp(rounding, order + 1))
            << "The shorter step is exact to rounding; the longer step has a larger error than its order permits.";
    else EXPECT_GE(std::log2(coarse.error / fine.error), order - 0.5);
}

// Dense output of a collocation method with s stages is its polynomial of degree s, with an error of order s + 1.
TYPED_TEST(DenseOutput, CollocationPolynomialHasOrderStagesPlusOne) {
    for_all_methods<TypeParam>([](const Method& method, bool rescaled) {
        if (!collocates(method)) return;
        const SpaceKernel<Quad>& kernel = space_kernel<TypeParam, Quad>(rescaled);
        expect_order<TypeParam>(method.info.name, method.coefficients.gauss->stages + 1, rescaled,
                                [&](const StepperState<Quad>& state) {
                                    return kernel.curve[static_cast<int>(method.kind)](state, method.coefficients);
                                });
    });
}

// Cubic Hermite interpolation is the dense output of all other methods. The ends of the step are computed by a method
// of order 16, so that only the error of the interpolation remains.
TYPED_TEST(DenseOutput, CubicHermiteHasOrderFour) {
    for (const bool rescaled : rescalings<TypeParam>())
        expect_order<TypeParam>("gauss16", 4, rescaled,
                                [](const StepperState<Quad>& state) { return Curve<Quad>::hermite(state); });
}

}  // namespace
}  // namespace kagero::test
