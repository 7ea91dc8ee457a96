// Tests of rays in spaces that are typed as in textbooks, in spherical coordinates: Schwarzschild and Kerr in
// Boyer–Lindquist form.
#include "tests/formula/formula_scene.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kagero::test {
namespace {

const std::string schwarzschild_keys =
    "capture = \"sqrt(x^2 + y^2 + z^2) - 2.05\"\n[space.constants]\nM = 1\npt = 1\n"
    "[space.let]\nf = \"1 - 2*M/sqrt(x^2 + y^2 + z^2)\"\n";

/// Returns the space of a black hole in Schwarzschild coordinates, with the part of H that contains the momenta.
std::string schwarzschild(const std::string& kinetic) {
    return "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(" + kinetic + " - pt^2/f)\"\n" + schwarzschild_keys;
}

const std::string cartesian = schwarzschild("px^2 + py^2 + pz^2 - 2*M*(x*px + y*py + z*pz)^2/(x^2 + y^2 + z^2)^1.5");

/// Kerr as printed. E is −p_t.
const char* const kerr_book =
    "[space]\nhamiltonian = \"formula\"\n"
    "H = \"(Delta*pr^2 + ptheta^2 + (pphi/sin(theta) - a*sin(theta)*E)^2"
    " - ((r^2 + a^2)*E - a*pphi)^2/Delta)/(2*Sigma)\"\n"
    "capture = \"r - 1.01*(M + sqrt(M^2 - a^2))\"\n[space.constants]\nM = 1\na = 0.9\npt = 1\n"
    "[space.let]\nE = \"-pt\"\nSigma = \"r^2 + a^2*cos(theta)^2\"\nDelta = \"r^2 - 2*M*r + a^2\"\n";
const char* const kerr_built_in = "[space]\nhamiltonian = \"kerr\"\nmass = 1\nspin = 0.9\n";

std::vector<RayEnd> ends_in(const std::string& space, const std::vector<RayStart>& starts, const Overrides& overrides) {
    const auto plan = plan_of_text(space + view_text, overrides, with_strategy("packet"), false);
    std::vector<RayEnd> ends;
    trace(*plan, starts, ends);
    return ends;
}

Double3 angular_momentum(const double (&q)[3], const double (&p)[3]) {
    return cross({q[0], q[1], q[2]}, {p[0], p[1], p[2]});
}

// The rays start at the same points with the same directions, so that the ends agree except for rounding. One fan
// passes near the axis, and another one contains the axis. The tolerance is that of FormulaOn.
TEST(TextbookSpaces, SchwarzschildHasTheSameRaysInSphericalAndCartesianForm) {
    std::vector<RayInput> rays = fan({-12, 0.5, 0.25});
    for (const double offset : {0.0, 1e-12, 1e-8, 1e-4, 0.3})
        for (const double slope : {-0.5, 0.0, 0.7, 1.3}) {
            rays.push_back({{offset, 0, 12}, {0, slope, -1}});
            rays.push_back({{-9, offset, 4}, {1, 0, slope}});
        }
    for (const char* kinetic :
         {"f*pr^2 + L2/r^2", "f*pr^2 + (ptheta^2 + pphi^2/sin(theta)^2)/r^2",
          "f*pr^2 + ptheta^2/r^2 + pphi^2/(r^2*sin(theta)^2)", "f*pr^2 + pphi^2/rho^2 + (ptheta/r)^2"})
        for (const char* method : {"gauss8", "dp5"}) {
            SCOPED_TRACE(std::string(kinetic) + ", " + method);
            const Overrides overrides{std::string("integrator.method=") + method, "integrator.step=0.05",
                                      "integrator.escape_radius=15"};
            const auto a = traced(schwarzschild(kinetic), overrides, "packet", rays),
                       b = traced(cartesian, overrides, "packet", rays);
            std::size_t escaped = 0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                ASSERT_EQ(a[i].status, b[i].status) << i << ' ' << static_cast<int>(a[i].failure);
                if (a[i].status != Status::escaped || b[i].steps > 1000) continue;
                for (int k = 0; k < 3; ++k) {
                    EXPECT_NEAR(a[i].q[k], b[i].q[k], 1e-12 * (1 + std::abs(b[i].q[k]))) << i;
                    EXPECT_NEAR(a[i].p[k], b[i].p[k], 1e-12 * (1 + std::abs(b[i].p[k]))) << i;
                }
                ++escaped;
            }
            EXPECT_GT(escaped, 20u);
        }
}

/// A point and momentum in Boyer–Lindquist coordinates, with φ = 0.
struct BoyerLindquist {
    double r, theta, pr, ptheta, pphi;
};

/// Returns a light ray that moves inward, with p_t = 1.
BoyerLindquist light_ray(double a, double r, double theta, double l, double carter, bool towards_pole) {
    const double delta = r * r - 2 * r + a * a, s = std::sin(theta), c = std::cos(theta),
                 potential = std::pow(r * r + a * a + a * l, 2) - delta * (carter + (l + a) * (l + a)),
                 square = carter + c * c * (a * a - l * l / (s * s));
    return {r, theta, -std::sqrt(potential) / delta, (towards_pole ? -1 : 1) * std::sqrt(std::max(square, 0.0)), l};
}

/// Returns the ray in Cartesian coordinates that belong to r, θ and φ as in flat space.
RayStart in_flat_map(const BoyerLindquist& at) {
    const double s = std::sin(at.theta), c = std::cos(at.theta);
    return {{at.r * s, 0, at.r * c},
            {at.pr * s + at.ptheta * c / at.r, at.pphi / (at.r * s), at.pr * c - at.ptheta * s / at.r}, 1,
            Failure::none, false, false};
}

/// Returns the ray in Kerr–Schild coordinates, outgoing form: t_BL = t + ∫2Mr/Δ dr, φ_BL = φ + ∫a/Δ dr, and
/// x + iy = (r − ia) sin θ e^{iφ}. The azimuth is not that of in_flat_map.
RayStart in_kerr_schild(const BoyerLindquist& at, double a) {
    const double s = std::sin(at.theta), c = std::cos(at.theta), r = at.r, delta = r * r - 2 * r + a * a,
                 pr = at.pr + (2 * r + a * at.pphi) / delta;
    // The rows are ∂(x, y, z)/∂(r, θ, φ); they are solved for p by Cramer's rule.
    const Double3 by_r{s, 0, c}, by_theta{r * c, -a * c, -r * s}, by_phi{a * s, r * s, 0},
        column = add(add(scaled(cross(by_theta, by_phi), pr), scaled(cross(by_phi, by_r), at.ptheta)),
                     scaled(cross(by_r, by_theta), at.pphi)),
        p = scaled(column, 1 / dot(by_r, cross(by_theta, by_phi)));
    return {{r * s, -a * s, r * c}, {p[0], p[1], p[2]}, 1, Failure::none, false, false};
}

/// Returns Carter's constant at the end of a ray of `kerr_book`, from L² − p_φ² + cos²θ (...).
double carter_constant(const double (&q)[3], const double (&p)[3], double a) {
    const Double3 l = angular_momentum(q, p);
    return l[0] * l[0] + l[1] * l[1] - a * a * q[2] * q[2] / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
}

// The edge of the shadow consists of the rays with the constants of spherical photon orbits (Bardeen 1973; Teo 2003).
// Rays just inside are captured, and rays just outside escape. Their constants are the same in both spaces.
TEST(TextbookSpaces, KerrHasTheShadowOfTheBuiltInSpace) {
    const double a = 0.9, distance = 30;
    std::vector<RayStart> book, built_in;
    std::vector<bool> captured;
    for (const double theta : {1.5, 0.9, 0.4})
        for (double orbit = 1.6; orbit < 3.95; orbit += 0.02) {
            const double xi = -(orbit * orbit * (orbit - 3) + a * a * (orbit + 1)) / (a * (orbit - 1)),
                         eta = orbit * orbit * orbit * (4 * a * a - orbit * std::pow(orbit - 3, 2)) /
                               (a * a * std::pow(orbit - 1, 2)),
                         s = std::sin(theta), c = std::cos(theta),
                         square = eta + c * c * (a * a - xi * xi / (s * s));
            if (square < 0.01) continue;  // no ray with these constants reaches this latitude
            for (const double factor : {1 - 1e-4, 1 + 1e-4}) {
                const double alpha = -factor * xi / s, beta2 = factor * factor * square, l = -alpha * s;
                const BoyerLindquist ray =
                    light_ray(a, distance, theta, -l, beta2 + c * c * (alpha * alpha - a * a), orbit > 2.5);
                book.push_back(in_flat_map(ray));
                built_in.push_back(in_kerr_schild(ray, a));
                captured.push_back(factor < 1);
            }
        }
    ASSERT_GT(book.size(), 200u);
    const Overrides overrides{"integrator.method=dp85", "integrator.tolerance=1e-12", "integrator.escape_radius=60",
                              "integrator.max_steps=100000"};
    const auto a_ends = ends_in(kerr_book, book, overrides), b_ends = ends_in(kerr_built_in, built_in, overrides);
    for (std::size_t i = 0; i < book.size(); ++i) {
        const Status expected = captured[i] ? Status::captured : Status::escaped;
        EXPECT_EQ(a_ends[i].status, expected) << i << " book";
        EXPECT_EQ(b_ends[i].status, expected) << i << " built-in";
        if (captured[i]) continue;
        const double l = angular_momentum(book[i].q, book[i].p)[2], q = carter_constant(book[i].q, book[i].p, a);
        EXPECT_NEAR(angular_momentum(a_ends[i].q, a_ends[i].p)[2], l, 1e-12) << i;
        EXPECT_NEAR(carter_constant(a_ends[i].q, a_ends[i].p, a), q, 1e-11) << i;
    }
}

// Rays without angular momentum about the axis pass over the poles. Rays close to them and on the axis have the same
// accuracy: their constants are conserved, and their ends are a smooth function of the distance from the axis.
TEST(TextbookSpaces, KerrHasNoSingularityOnTheAxis) {
    const double a = 0.9;
    const Overrides overrides{"integrator.method=gauss8", "integrator.step=0.02", "integrator.escape_radius=30",
                              "integrator.max_steps=100000"};
    std::vector<RayStart> starts;
    for (const double l : {0.0, 1e-14, 1e-10, 1e-6, -1e-6, 1e-3})
        for (const double carter : {40.0, 60.0, 100.0})
            starts.push_back(in_flat_map(light_ray(a, 15, 1.2, l, carter, true)));
    RayStart axis = in_flat_map({15, 0, -1, 0, 0});
    for (const double x : {0.0, 1e-14, 1e-9}) {
        axis.q[0] = x;
        axis.p[0] = 0.1;
        axis.p[1] = 0;
        // H is a quadratic function of p_z; its positive root is that of light.
        const double r = std::hypot(x, 15), delta = r * r - 2 * r + a * a;
        const double radial = (std::pow(r * r + a * a, 2) / delta - 0.01 * r * r) / delta;
        axis.p[2] = std::sqrt(radial);
        starts.push_back(axis);
    }
    const auto ends = ends_in(kerr_book, starts, overrides);
    for (std::size_t i = 0; i < starts.size(); ++i) {
        EXPECT_EQ(ends[i].status, Status::escaped) << i << ' ' << static_cast<int>(ends[i].failure);
        EXPECT_NEAR(angular_momentum(ends[i].q, ends[i].p)[2], angular_momentum(starts[i].q, starts[i].p)[2], 2e-12);
        const double q = carter_constant(starts[i].q, starts[i].p, a);
        EXPECT_NEAR(carter_constant(ends[i].q, ends[i].p, a), q, 1e-10 * (1 + q)) << i;
    }
    for (std::size_t i = 3; i < 9; ++i)
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(ends[i].q[k], ends[i % 3].q[k], 1e-8) << i;
}

// A formula whose singular terms do not cancel has no rays on the axis. The reason is reported.
TEST(TextbookSpaces, RaysFailOnTheAxisIfHIsSingularThere) {
    const std::string space =
        "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(pr^2 + (ptheta^2 + 1.1*pphi^2/sin(theta)^2)/r^2 - 1)\"\n";
    const auto ends = traced(space, {"integrator.escape_radius=9"}, "packet",
                             {{{0, 0, 3}, {0.1, 0, -1}}, {{3, 0, 3}, {0.1, 1, -1}}});
    EXPECT_EQ(ends[0].status, Status::failed);
    EXPECT_EQ(ends[0].failure, Failure::singular_start);
    EXPECT_EQ(ends[1].status, Status::escaped);
}

}  // namespace
}  // namespace kagero::test
