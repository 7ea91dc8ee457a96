// Tests of the parts into which Hamiltonians are split for splitting methods. The parts must sum to H, and flows that
// are defined in closed form must agree with numerical integration.
#include "tests/kernels/steps.h"

#include "kernels/integrators/gauss.h"

namespace kagero::test {
namespace {

template <class H>
class Splitting : public ::testing::Test {};
TYPED_TEST_SUITE(Splitting, AllHamiltonians, HamiltonianName);

TYPED_TEST(Splitting, PartsSumToTheHamiltonian) {
    using H = TypeParam;
    if constexpr (!Parted<H>) {
        GTEST_SKIP() << H::name << " defines no parts.";
    } else {
        Random random(41);
        const auto k = make_parameters<H>(default_parameters<H>().data());
        for (const RayStart& ray : random_rays<H>(200, 42)) {
            const Vec3<double> q{ray.q[0], ray.q[1], ray.q[2]},
                p = random(0.5, 2) * Vec3<double>{ray.p[0], ray.p[1], ray.p[2]};
            const double pt = ray.pt * random(0.5, 2), a = H::part_a(k, q, p, pt), b = H::part_b(k, q, p, pt);
            EXPECT_NEAR(a + b, H::energy(k, q, p, pt),
                        30 * machine_epsilon<double> * (dot(p, p) + pt * pt + std::abs(a) + std::abs(b)));
        }
    }
}

/// The Hamiltonian H − ½(|p|² − p_t²), whose flow is H::remainder_flow.
template <class H>
struct Remainder {
    static constexpr const auto& parameters = H::parameters;
    static constexpr double level = 0;
    template <class V>
    using Parameters = typename H::template Parameters<V>;
    template <class V>
    static constexpr V energy(const Parameters<V>& k, const Vec3<V>& q, const Vec3<V>& p, const V& pt) {
        return H::energy(k, q, p, pt) - 0.5 * (dot(p, p) - pt * pt);
    }
};

/// Integrates a state from λ = 0 to λ = t by n steps of a collocation method of order 16.
template <class System>
State<Quad> integrate(const System& system, const State<Quad>& start, Quad t, int n) {
    StepperState<Quad> state{};
    const Coefficients coefficients{.gauss = &gauss_tableau<8>};
    static_cast<State<Quad>&>(state.start) = start;
    state.h = t / n;
    Gauss<0>::begin(system, state, coefficients);
    for (int i = 0; i < n; ++i) {
        state.start.velocity = system.gradient_p(state.start);
        Gauss<0>::step(system, state, coefficients);
        EXPECT_TRUE(state.solved);
        state.start = state.end;
    }
    return state.start;
}

// The reference is numerical integration with 16 steps in quadruple precision. Its error is estimated by comparison
// with 8 steps.
TYPED_TEST(Splitting, ClosedFormFlowMatchesIntegration) {
    using H = TypeParam;
    if constexpr (!ExactlySplit<H>) {
        GTEST_SKIP() << H::name << " defines no flow in closed form.";
    } else {
        const System<Remainder<H>, false, Quad> system(default_parameters<H>().data());
        const auto k = system.template parameters<Quad>();
        int compared = 0;
        for (const RayStart& ray : random_rays<H>(30, 43)) {
            const State<Quad> start = state_of<Quad>(ray);
            for (const double t : {-0.75, 0.25, 1.5}) {
                Vec3<Quad> q = start.q(), p = start.p();
                H::remainder_flow(k, q, p, start.y[6], Quad(t));
                // Rays that end closer to the centre than half of their initial distance are left out, because the
                // reference is not accurate enough there.
                if (norm(q) < norm(start.q()) / 2) continue;
                const State<Quad> coarse = integrate(system, start, t, 8), fine = integrate(system, start, t, 16);
                const Quad end[6] = {q.x, q.y, q.z, p.x, p.y, p.z};
                for (int i = 0; i < 6; ++i) {
                    const Quad tolerance =
                        abs(fine.y[i] - coarse.y[i]) + 1000 * machine_epsilon<Quad> * (1 + abs(fine.y[i]));
                    EXPECT_LE(static_cast<double>(abs(end[i] - fine.y[i]) / tolerance), 1)
                        << "component " << i << " at t = " << t;
                }
                ++compared;
            }
        }
        EXPECT_GT(compared, 60);
    }
}

// Rays towards the centre must be captured, also if a step passes through the centre. The states of the rays must stay
// finite.
TYPED_TEST(Splitting, RaysThroughTheCentreAreCaptured) {
    using H = TypeParam;
    if constexpr (!ExactlySplit<H>) {
        GTEST_SKIP() << H::name << " defines no flow in closed form.";
    } else {
        const auto k = make_parameters<H>(default_parameters<H>().data());
        Random random(44);
        for (const RayStart& start : random_rays<H>(100, 45)) {
            Vec3<double> q{start.q[0], start.q[1], start.q[2]}, p{start.p[0], start.p[1], start.p[2]};
            H::remainder_flow(k, q, p, start.pt, 1e4);
            EXPECT_LE(H::captured(k, q, p, p, 1.0), 0);
            double inward[3];
            for (int i = 0; i < 3; ++i) inward[i] = -start.q[i] + random(-0.25, 0.25);
            RayStart ray;
            ASSERT_EQ(start_ray<H>(start.q, inward, ray), Failure::none);
            for (const Method& method : methods_for<H>(false)) {
                if (method.kind != StepperKind::exact_split) continue;
                SCOPED_TRACE(method.info.name);
                auto stepper = SpaceStepper<double>::for_space<H>(method, false);
                stepper.begin(state_of<double>(ray), H::step);
                for (int i = 0; i < 200 && (i == 0 || stepper.state.end.captured > 0); ++i) {
                    stepper.advance(1);
                    for (const double y : stepper.state.end.y) EXPECT_TRUE(std::isfinite(y));
                }
                EXPECT_LE(stepper.state.end.captured, 0) << "at r = " << norm(stepper.state.end.q());
            }
        }
    }
}

}  // namespace
}  // namespace kagero::test
