// Between the ends of a step dense output follows the ray with the order it states.
#include "tests/kernels/steps.h"

#include <algorithm>
#include <cmath>

namespace kagero::test {
namespace {

template <class H>
class DenseOutput : public ::testing::Test {};
TYPED_TEST_SUITE(DenseOutput, AllHamiltonians, HamiltonianName);

template <class H>
Steps<Quad> one_step(const std::string& method, bool rescaled, int ray, Quad h) {
    auto run = Steps<Quad>::template in<H>(method_named(method), rescaled);
    run.begin(state_of<Quad>(bent_ray<H>(ray)), h);
    run.step();
    return run;
}

/// How far the curve of one step of length h is off, inside the step, and how long it is; summed over rays. The
/// reference goes there by a step of its own.
struct Off {
    double error = 0, length = 0;
};
template <class H, class CurveOf>
Off off_inside(const std::string& method, bool rescaled, Quad h, const CurveOf& curve_of) {
    Off off;
    for (int ray = 0; ray < bent_rays; ++ray) {
        const auto run = one_step<H>(method, rescaled, ray, h);
        const Curve<Quad> curve = curve_of(run.flow);
        const auto distance = [](const Vec3<Quad>& a, const Vec3<Quad>& b) {
            return std::sqrt(static_cast<double>(dot(a - b, a - b)));
        };
        EXPECT_EQ(distance(curve.at(Quad(0)), run.flow.start.q()), 0);
        EXPECT_EQ(distance(curve.at(Quad(1)), run.flow.end.q()), 0);
        off.length += distance(run.flow.start.q(), run.flow.end.q());
        for (const double s : {0.19, 0.44, 0.78})
            off.error += distance(curve.at(Quad(s)), one_step<H>("gauss16", rescaled, ray, Quad(s) * h).flow.end.q());
    }
    return off;
}

/// From a step to one half as long the error falls by 2^order.
template <class H, class CurveOf>
void expect_order(const std::string& method, int order, bool rescaled, const CurveOf& curve_of) {
    SCOPED_TRACE(method + (rescaled ? ", rescaled" : ""));
    const Quad h = Quad(path_length<H>) / 64;
    const Off coarse = off_inside<H>(method, rescaled, h, curve_of),
              fine = off_inside<H>(method, rescaled, h / 2, curve_of);
    const double rounding = 1e-30 * coarse.length;
    if (fine.error <= rounding) EXPECT_LE(coarse.error, std::ldexp(rounding, order + 1)) << "exact, or nearly so";
    else EXPECT_GE(std::log2(coarse.error / fine.error), order - 0.5);
}

TYPED_TEST(DenseOutput, OfCollocationIsItsPolynomial) {
    for_all_methods<TypeParam>([](const Method& method, bool rescaled) {
        if (!collocates(method)) return;
        const SpaceKernel<Quad>& kernel = space_kernel<TypeParam, Quad>(rescaled);
        expect_order<TypeParam>(method.info.name, method.coefficients.gauss->stages + 1, rescaled,
                                [&](const StepperState<Quad>& flow) {
                                    return kernel.curve[static_cast<int>(method.kind)](flow, method.coefficients);
                                });
    });
}

TYPED_TEST(DenseOutput, OfOthersIsCubicHermite) {
    for (const bool rescaled : rescalings<TypeParam>())
        expect_order<TypeParam>("gauss16", 4, rescaled,
                                [](const StepperState<Quad>& flow) { return Curve<Quad>::hermite(flow); });
}

}  // namespace
}  // namespace kagero::test
