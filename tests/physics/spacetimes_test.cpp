// Compares rays around Kerr's black hole, rays through Ellis's wormhole, and rays of all kinds of observers with closed
// forms.
#include "tests/support/plan_fixture.h"

#include <boost/math/special_functions/ellint_1.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kagero::test {
namespace {

std::unique_ptr<Plan> plan_of_space(const std::string& space, const std::string& integrator,
                                    const char* strategy = "packet", const Overrides& overrides = {},
                                    const std::string& observer = "") {
    const std::string scene =
        "[space]\n" + space + "\n[integrator]\nmethod = \"gauss12\"\nstep = 0.1\nmax_steps = 1000000\n" + integrator +
        "\n[camera]\nposition = [0, -10, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [4, 4]\n";
    Options options = with_strategy(strategy);
    options.observer = observer_of(observer);
    return plan_of_text(scene, overrides, options, false);
}

std::vector<RayEnd> ends_of(const Plan& plan, const std::vector<RayStart>& starts) {
    std::vector<RayEnd> ends;
    trace(plan, starts, ends);
    return ends;
}
std::vector<RayEnd> ends_of(const Plan& plan, const std::vector<RayInput>& rays, const std::string& observer = "") {
    return ends_of(plan, start_rays(plan, rays, observer_of(observer)));
}

/// Returns the number x between `inside` and `outside` at which the rays ray_at(x) change from captured to escaped.
/// Each round divides the interval that contains x by 15 (16 rays fill a packet), until it is shorter than `width`.
template <class RayAt>
double capture_boundary(const Plan& plan, double inside, double outside, const RayAt& ray_at, double width) {
    constexpr int parts = 15;
    while (std::abs(outside - inside) > width) {
        std::vector<RayStart> starts;
        for (int i = 0; i <= parts; ++i) starts.push_back(ray_at(inside + (outside - inside) * i / parts));
        const auto ends = ends_of(plan, starts);
        int captured_count = 0;
        for (const RayEnd& end : ends) {
            if (end.status != Status::captured) break;
            ++captured_count;
        }
        EXPECT_TRUE(captured_count > 0 && captured_count <= parts)
            << captured_count << " in " << inside << ' ' << outside;
        if (captured_count == 0 || captured_count > parts) break;
        const double part = (outside - inside) / parts;
        outside = inside + captured_count * part;
        inside = outside - part;
    }
    return 0.5 * (inside + outside);
}

/// Returns the relative bound of the errors of critical impact parameters. Around a hole of spin 1, the steps of a
/// prograde ray grow with the square root of 1/|b − b_c|, instead of its logarithm.
double critical_bound(double spin) { return spin == 1 ? 3e-5 : 1e-7; }

// The critical impact parameters in the equatorial plane are b = ±6M cos(⅓ arccos(∓a/M)) − a (Chandrasekhar 1983, §61,
// eq. 82). Rays are integrated backward in time. At p_t = 1, the impact parameter of the light is therefore
// b = −(x p_y − y p_x).
TEST(Kerr, CriticalImpactParametersMatchTheClosedForm) {
    for (const double spin : {0.0, 0.5, 0.9, 0.998, 1.0}) {
        const auto plan = plan_of_space("hamiltonian = \"kerr\"\nspin = " + std::to_string(spin), "escape_radius = 60");
        for (const double side : {1.0, -1.0}) {
            const double expected = side * 6 * std::cos(std::acos(-side * spin) / 3) - spin;
            const auto ray_at = [&](double angle) {  // from (0, −50, 0) towards the hole, to −x or +x
                return start_rays(*plan, {{{0, -50, 0}, {-side * std::sin(angle), std::cos(angle), 0}}},
                                  ObserverKind::zamo)[0];
            };
            const double found = capture_boundary(*plan, 0, 0.3, ray_at, 0.02 * critical_bound(spin));
            const RayStart critical = ray_at(found);
            const double b = -(critical.q[0] * critical.p[1] - critical.q[1] * critical.p[0]) / critical.pt;
            EXPECT_NEAR(b, expected, critical_bound(spin) * std::abs(expected)) << "spin " << spin << ", side " << side;
        }
    }
}

// A ray that moves inward is captured if Carter's R(r) = ((r² + a²) p_t + a L)² − Δ (Q + (L + a p_t)²) has no zero at a
// smaller radius outside the horizon (Chandrasekhar 1983, §62). Q is computed from p_θ. Capture must be detected within
// 200 steps, also near an extreme black hole, and for rays of falling observers, which never reach the horizon.
TEST(Kerr, RaysWithoutTurningPointAreCaptured) {
    for (const double spin : {0.5, 0.998, 1.0, -1.0})
        for (const char* observer : {"static", "zamo", "falling"})
            for (const char* precision : {"double", "float"}) {
                Options options = with_strategy("packet");
                options.observer = observer_of(observer);
                options.precision = precision_named(precision);
                const auto plan = plan_of_text(
                    "[space]\nhamiltonian = \"kerr\"\nspin = " + std::to_string(spin) +
                        "\n[integrator]\nescape_radius = 40\n[camera]\nposition = [0, -8, 1]\nlook_at = [0, 0, 0]\n"
                        "up = [0, 0, 1]\nfov = 90\n[film]\nsize = [40, 30]\n",
                    {}, options);
                std::vector<RayStart> starts;
                for (std::uint32_t i = 0; i < 40 * 30; ++i) starts.push_back(pixel_ray_start(*plan, i % 40, i / 40));
                const auto ends = ends_of(*plan, starts);
                int captured = 0;
                for (std::size_t i = 0; i < ends.size(); ++i) {
                    const auto &q = starts[i].q, &p = starts[i].p;
                    const double pt = starts[i].pt, a = spin, a2 = a * a, square = q[0] * q[0] + q[1] * q[1],
                                 b = square + q[2] * q[2] - a2;
                    const double r = std::sqrt(0.5 * (b + std::sqrt(b * b + 4 * a2 * q[2] * q[2]))), cosine = q[2] / r,
                                 sine2 = 1 - cosine * cosine;
                    const double L = q[0] * p[1] - q[1] * p[0];
                    const double p_theta =
                        (q[0] * p[0] + q[1] * p[1]) * cosine / std::sqrt(sine2) - r * std::sqrt(sine2) * p[2];
                    const double Q = p_theta * p_theta + cosine * cosine * (L * L / sine2 - a2 * pt * pt);
                    double least_R = std::numeric_limits<double>::infinity();
                    for (double s = 1 + std::sqrt(1 - a2); s < r; s += 1e-3) {  // R(s) from the horizon to the start
                        const double sum = (s * s + a2) * pt + a * L, dragged = L + a * pt;
                        least_R = std::min(least_R, sum * sum - (s * s - 2 * s + a2) * (Q + dragged * dragged));
                    }
                    if (std::abs(least_R) < 0.1) continue;
                    EXPECT_EQ(ends[i].status, least_R > 0 ? Status::captured : Status::escaped)
                        << spin << ' ' << observer << ' ' << precision << ' ' << i;
                    EXPECT_LT(ends[i].steps, 200) << spin << ' ' << observer << ' ' << precision << ' ' << i;
                    captured += ends[i].status == Status::captured;
                }
                EXPECT_GT(captured, 100);
            }
}

TEST(Kerr, RaysWithoutSpinMatchSchwarzschild) {
    const auto kerr = plan_of_space("hamiltonian = \"kerr\"\nmass = 0.5\nspin = 0", "escape_radius = 30");
    const auto schwarzschild = plan_of_space("hamiltonian = \"schwarzschild\"\nrg = 1", "escape_radius = 30");
    std::vector<RayInput> rays;
    for (int i = 0; i < 24; ++i) rays.push_back({{10, 1, 2}, {-1, 0.04 * (i - 12) - 0.1, -0.03 * i}});
    const auto a = ends_of(*kerr, rays), b = ends_of(*schwarzschild, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(a[i].status, b[i].status);
        if (a[i].status != Status::escaped) continue;
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(a[i].v[k], b[i].v[k], 1e-9);
    }
}

// Carter's constant for null rays is Q = p_θ² + cos²θ (L²/sin²θ − a² p_t²). It is computed in Boyer–Lindquist
// coordinates, while the rays are integrated in Kerr–Schild coordinates.
TEST(Kerr, AngularMomentumAndCartersConstantAreConserved) {
    const double a = 0.9;
    const auto plan = plan_of_space("hamiltonian = \"kerr\"\nspin = 0.9", "escape_radius = 40");
    const auto carter_constant = [&](const double (&q)[3], const double (&p)[3], double pt) {
        const double b = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] - a * a;
        const double r2 = 0.5 * (b + std::sqrt(b * b + 4 * a * a * q[2] * q[2])), r = std::sqrt(r2);
        const double cosine = q[2] / r, sine2 = 1 - cosine * cosine, l = q[0] * p[1] - q[1] * p[0];
        // ∂x/∂θ at constant r: (x, y) cot θ, −r sin θ.
        const double p_theta = (q[0] * p[0] + q[1] * p[1]) * cosine / std::sqrt(sine2) - r * std::sqrt(sine2) * p[2];
        return p_theta * p_theta + cosine * cosine * (l * l / sine2 - a * a * pt * pt);
    };
    std::vector<RayInput> rays;
    for (int i = 0; i < 20; ++i) rays.push_back({{20, 3, 5}, {-1, 0.03 * i - 0.5, 0.02 * i - 0.3}});
    const auto starts = start_rays(*plan, rays);
    const auto ends = ends_of(*plan, starts);
    const auto angular_momentum = [](const double (&q)[3], const double (&p)[3]) { return q[0] * p[1] - q[1] * p[0]; };
    std::size_t compared = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (ends[i].status != Status::escaped) continue;
        ++compared;
        EXPECT_NEAR(angular_momentum(ends[i].q, ends[i].p), angular_momentum(starts[i].q, starts[i].p), 1e-9) << i;
        const double before = carter_constant(starts[i].q, starts[i].p, 1);
        const double after = carter_constant(ends[i].q, ends[i].p, 1);
        EXPECT_NEAR(after, before, 1e-9 * (1 + std::abs(before))) << i;
    }
    EXPECT_GE(compared, 10u);
}

/// Strategy, method and step with which a test is run. The tolerance is that of the swept angle, in radians.
struct Variant {
    const char *name, *strategy, *method, *step;
    double tolerance;
    friend void PrintTo(const Variant& variant, std::ostream* out) { *out << variant.name; }
};
class Wormhole : public testing::TestWithParam<Variant> {
protected:
    static constexpr double throat = 1, far = 30;
    std::unique_ptr<Plan> plan =
        plan_of_space("hamiltonian = \"wormhole\"\nthroat = 1", "escape_radius = 30", GetParam().strategy,
                      {std::string("integrator.method=") + GetParam().method,
                       std::string("integrator.step=") + GetParam().step});
    /// Returns a ray that starts at the proper distance l = 30 on the +x axis and moves inward with the impact
    /// parameter b.
    static RayInput ray(double b) {
        const double rho = 0.5 * (far + std::sqrt(far * far + throat * throat)), sine = b / std::hypot(far, throat);
        return {{rho, 0, 0}, {-std::sqrt(1 - sine * sine), sine, 0}};
    }
};

// The throat has the radius a = 1, and l is the proper distance from it. Rays with b < a end on the second sheet, at
// l = −30. Rays with b > a end at l = 30.
TEST_P(Wormhole, RaysBelowTheCriticalImpactParameterPassTheThroat) {
    for (const double distance : {1e-6, 1e-4, 1e-2, 0.5}) {
        const auto ends = ends_of(*plan, {ray(throat * (1 - distance)), ray(throat * (1 + distance))});
        ASSERT_EQ(ends[0].status, Status::escaped);
        ASSERT_EQ(ends[1].status, Status::escaped);
        const auto proper_distance = [](const RayEnd& e) {
            const double rho = std::hypot(e.q[0], e.q[1], e.q[2]);
            return rho - throat * throat / (4 * rho);
        };
        EXPECT_NEAR(proper_distance(ends[0]), -far, 1e-8 * far) << distance;
        EXPECT_NEAR(proper_distance(ends[1]), far, 1e-8 * far) << distance;
    }
}

// The swept angle is b ∫ dl / √((l² + a²)(l² + a² − b²)) (Byrd & Friedman, 221.00 and 211.00).
TEST_P(Wormhole, SweptAngleMatchesTheEllipticIntegral) {
    using boost::math::ellint_1;
    for (const double b : {0.1, 0.5, 0.9, 0.999, 1.001, 1.1, 2.0, 5.0}) {
        const RayEnd end = ends_of(*plan, {ray(b)})[0];
        const double swept = std::atan2(end.q[1], end.q[0]);
        double expected;
        if (b < throat) {
            const double k = b / throat, phi = std::atan(far / std::sqrt(throat * throat - b * b));
            expected = 2 * b / throat * ellint_1(k, phi);
        } else {
            const double k = throat / b, phi = std::acos(std::sqrt(b * b - throat * throat) / far);
            expected = 2 * ellint_1(k, phi);
        }
        EXPECT_NEAR(std::remainder(swept - expected, 2 * std::numbers::pi), 0, GetParam().tolerance) << "b = " << b;
    }
}
INSTANTIATE_TEST_SUITE_P(Strategies, Wormhole,
                         testing::Values(Variant{"scalar", "scalar", "gauss12", "0.1", 1e-9},
                                         Variant{"packet", "packet", "gauss12", "0.1", 1e-9},
                                         Variant{"orbit", "packet", "orbit-srkn14", "0.05", 1e-8}),
                         [](const auto& chosen) { return std::string(chosen.param.name); });

// An observer who falls from rest at infinity has the speed s = √(r_g/r). For the direction d, the energy is E = 1 + s
// d_r. In ingoing coordinates, p_r = d_r + E s/(1 + s) and p_⊥ = d_⊥, also on and inside the horizon, and the kernel's
// p_t is −E. Rays that start at r ≥ 2 r_g are in outgoing coordinates, with p_t = E; p_r is greater by
// 2 E r_g/(r − r_g).
TEST(FallingObserver, MomentaInSchwarzschildMatchTheClosedForm) {
    const auto plan = plan_of_space("hamiltonian = \"schwarzschild\"\nrg = 1", "escape_radius = 30");
    for (const double r : {10.0, 3.0, 1.0, 0.5}) {
        for (const double angle : {0.0, 0.7, 2.0, 3.1}) {
            const double d_r = std::cos(angle), s = std::sqrt(1 / r);
            const RayStart start =
                start_rays(*plan, {{{r, 0, 0}, {d_r, std::sin(angle), 0}}}, ObserverKind::falling)[0];
            ASSERT_EQ(start.failure, Failure::none) << r;
            const double energy = 1 + s * d_r;
            EXPECT_EQ(start.ingoing, r < 2);
            EXPECT_NEAR(start.pt, start.ingoing ? -energy : energy, 1e-12);
            EXPECT_NEAR(start.p[0], d_r + energy * s / (1 + s) + (start.ingoing ? 0 : 2 * energy / (r - 1)), 1e-12);
            EXPECT_NEAR(start.p[1], std::sin(angle), 1e-12);
        }
    }
}

// The static observer at 3 r_g sees a shadow of 45°. Aberration with the speed √(r_g/r) reduces it to 24.20°.
TEST(FallingObserver, ShadowMatchesAberration) {
    const auto plan = plan_of_space("hamiltonian = \"schwarzschild\"\nrg = 1", "escape_radius = 30");
    const auto shadow = [&](double r) {
        return capture_boundary(*plan, 0.01, 3.0, [&](double angle) {
            return start_rays(*plan, {{{0, -r, 0}, {std::sin(angle), std::cos(angle), 0}}}, ObserverKind::falling)[0];
        }, 1e-10);
    };
    const double beta = std::sqrt(1 / 3.0), cosine = std::cos(std::numbers::pi / 4);
    EXPECT_NEAR(shadow(3), std::acos((cosine + beta) / (1 + beta * cosine)), 1e-7);
    EXPECT_NEAR(shadow(3) * 180 / std::numbers::pi, 24.20, 0.005);
    EXPECT_GT(shadow(1.0), shadow(3));    // on the horizon
    EXPECT_GT(shadow(0.7), shadow(1.0));  // inside the horizon
}

// The critical impact parameters do not depend on the observer. The left edge of the shadow has the impact parameter of
// prograde light, (x p_y − y p_x)/p_t.
TEST(FallingObserver, CriticalImpactParametersInKerrMatchTheClosedForm) {
    for (const double spin : {0.9, 1.0}) {
        const auto plan = plan_of_space("hamiltonian = \"kerr\"\nspin = " + std::to_string(spin), "escape_radius = 60",
                                    "packet", {}, "falling");
        for (const double side : {1.0, -1.0}) {
            const auto ray_at = [&](double angle) {  // from (0, −50, 0) towards the hole, to −x or +x
                return start_rays(*plan, {{{0, -50, 0}, {-side * std::sin(angle), std::cos(angle), 0}}},
                                  ObserverKind::falling)[0];
            };
            const RayStart critical = ray_at(capture_boundary(*plan, 0, 0.3, ray_at, 0.02 * critical_bound(spin)));
            const double expected = side * 6 * std::cos(std::acos(-side * spin) / 3) - spin;
            const double b = (critical.q[0] * critical.p[1] - critical.q[1] * critical.p[0]) / critical.pt;
            EXPECT_NEAR(b, -expected, critical_bound(spin) * std::abs(expected)) << spin << ' ' << side;
        }
    }
}

// An observer of the kind `zamo` has zero angular momentum. Its energy is compared with the lapse of Bardeen, Press &
// Teukolsky (1972).
TEST(ZamoObserver, HasZeroAngularMomentumAndTheEnergyOfTheLapse) {
    const double a = 0.9, x = 4, r = std::sqrt(x * x - a * a);
    const auto plan = plan_of_space("hamiltonian = \"kerr\"\nspin = 0.9", "escape_radius = 30");
    StartMap map;
    const double q[3] = {x, 0, 0};
    ASSERT_EQ(plan->scene->space.observe(ObserverKind::zamo, q, false, map), Failure::none);
    // −offset is the covariant 4-velocity u of the observer. Its angular momentum is x u_y − y u_x.
    EXPECT_NEAR(q[0] * map.offset[1] - q[1] * map.offset[0], 0, 1e-13);
    const double delta = r * r - 2 * r + a * a, A = (r * r + a * a) * (r * r + a * a) - a * a * delta;
    EXPECT_NEAR(map.offset[3], std::sqrt(r * r * delta / A), 1e-12);
    // Inside the ergosphere (r < 2 in the equatorial plane) no static observer exists, but an observer `zamo` exists.
    const double inside[3] = {std::sqrt(1.7 * 1.7 + a * a), 0, 0};
    EXPECT_EQ(plan->scene->space.observe(ObserverKind::static_, inside, false, map), Failure::no_observer);
    EXPECT_EQ(plan->scene->space.observe(ObserverKind::zamo, inside, false, map), Failure::none);
    // Observers inside the inner horizon (r₋ = 0.56) are refused, although time and radius have the same directions
    // there as outside the hole.
    const double innermost[3] = {0.3, 0, 0.1};
    for (const auto kind : {ObserverKind::static_, ObserverKind::zamo})
        EXPECT_EQ(plan->scene->space.observe(kind, innermost, false, map), Failure::no_observer);
}

// The momenta of rays of all observers satisfy H = 0.
TEST(Observers, StartNullRays) {
    for (const char* space :
         {"hamiltonian = \"kerr\"\nspin = 0.7", "hamiltonian = \"schwarzschild\"", "hamiltonian = \"wormhole\""}) {
        for (const char* observer : {"static", "zamo", "falling", "coordinate"}) {
            const auto plan = plan_of_space(space, "escape_radius = 40", "packet", {}, observer);
            if (std::string(space).find("wormhole") != std::string::npos && std::string(observer) == "falling")
                continue;
            std::vector<RayInput> rays;
            for (int i = 0; i < 12; ++i)
                rays.push_back({{3, 4, 2}, {std::cos(i * 1.1), std::sin(i * 1.1), std::cos(2.3 * i)}});
            const auto starts = start_rays(*plan, rays, observer_of(observer));
            std::vector<RayEnd> ends;
            for (const PathPoint& point : trace_paths(*plan, starts, ends)) {
                if (point.step > 0) continue;
                EXPECT_NEAR(point.energy, 0, 1e-13) << space << ' ' << observer;
            }
            for (const RayStart& start : starts) EXPECT_EQ(start.failure, Failure::none);
        }
    }
    const auto plan = plan_of_space("hamiltonian = \"wormhole\"", "escape_radius = 40");
    EXPECT_EQ(start_rays(*plan, {{{3, 4, 2}, {1, 0, 0}}}, ObserverKind::falling)[0].failure, Failure::no_observer);
}

}  // namespace
}  // namespace kagero::test
