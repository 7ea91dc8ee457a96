// The parts of Hamiltonians for splitting methods. Their sum must be H, and flows that are defined in closed form must
// agree with numerical integration.
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

/// Integrates a state over the time t by n steps of a method of order 16.
template <class System>
State<Quad> integrate(const System& system, const State<Quad>& start, Quad t, int n) {
    StepperState<Quad> f{};
    const Coefficients coefficients{.gauss = &gauss_tableau<8>};
    static_cast<State<Quad>&>(f.start) = start;
    f.h = t / n;
    Gauss<0>::begin(system, f, coefficients);
    for (int i = 0; i < n; ++i) {
        f.start.velocity = system.dp(f.start);
        Gauss<0>::step(system, f, coefficients);
        EXPECT_TRUE(f.solved);
        f.start = f.end;
    }
    return f.start;
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
                // Steps that approach the centre to less than half of the initial distance are not accurate enough as a
                // reference.
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

// Rays towards the centre are captured, also by steps that pass through the centre. Their states must stay finite.
TYPED_TEST(Splitting, RaysThroughTheCentreAreCaptured) {
    using H = TypeParam;
    if constexpr (!ExactlySplit<H>) {
        GTEST_SKIP() << H::name << " defines no flow in closed form.";
    } else {
        const auto k = make_parameters<H>(default_parameters<H>().data());
        Random random(44);
        for (const RayStart& from : random_rays<H>(100, 45)) {
            Vec3<double> q{from.q[0], from.q[1], from.q[2]}, p{from.p[0], from.p[1], from.p[2]};
            H::remainder_flow(k, q, p, from.pt, 1e4);
            EXPECT_LE(H::captured(k, q, p, p, 1.0), 0);
            double inward[3];
            for (int i = 0; i < 3; ++i) inward[i] = -from.q[i] + random(-0.25, 0.25);
            RayStart ray;
            ASSERT_EQ(start_ray<H>(from.q, inward, ray), Failure::none);
            for (const Method& method : methods_for<H>(false)) {
                if (method.kind != StepperKind::exact_split) continue;
                SCOPED_TRACE(method.info.name);
                auto steps = Steps<double>::in<H>(method, false);
                steps.begin(state_of<double>(ray), H::step);
                for (int i = 0; i < 200 && (i == 0 || steps.state.end.captured > 0); ++i) {
                    steps.advance(1);
                    for (const double y : steps.state.end.y) EXPECT_TRUE(std::isfinite(y));
                }
                EXPECT_LE(steps.state.end.captured, 0) << "at r = " << norm(steps.state.end.q());
            }
        }
    }
}

}  // namespace
}  // namespace kagero::test
