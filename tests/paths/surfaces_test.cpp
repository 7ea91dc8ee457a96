// Rays that continue at surfaces: Snell's law and Fresnel's formulas, mirrors, lenses with faces, and reversibility, on
// every instruction set. The expected values are closed forms or quadratures.
#include "tests/support/plan_fixture.h"

#include "scene/vector3.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kagero::test {
namespace {

/// Tables that scene files need, but lists of rays do not use.
const std::string unused_camera =
    "[camera]\nposition = [0, -1, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [4, 4]\n";

constexpr double pi = std::numbers::pi;

/// The ends of rays and the states of their paths.
struct Traced {
    std::vector<RayEnd> ends;
    std::vector<PathState> paths;
};

class Surfaces : public testing::TestWithParam<std::string> {
protected:
    /// Traces rays through up to `bounces` surfaces.
    static Traced trace_rays(const std::string& scene, const std::vector<RayInput>& rays, std::uint32_t bounces) {
        Options options;
        options.isa = GetParam();
        options.bounces = bounces;
        options.parameter = true;
        const auto plan = plan_of_text(scene + unused_camera, {}, options, false);
        Traced traced;
        trace(*plan, start_rays(*plan, rays), traced.ends, {}, &traced.paths);
        return traced;
    }
};

INSTANTIATE_TEST_SUITE_P(Isas, Surfaces, testing::ValuesIn(supported_isas()),
                         [](const auto& isa) { return isa.param; });

/// Returns a scene in a space, with a medium "glass" and objects.
std::string scene_with(const std::string& space, const std::string& glass, const std::string& objects) {
    return "[space]\n" + space + "\n[integrator]\nescape_radius = 100\n[[medium]]\nname = \"glass\"\n" + glass + "\n" +
           objects;
}

std::string uniform(double index) {
    std::ostringstream text;
    text.precision(17);
    text << "hamiltonian = \"uniform\"\nn0 = " << index;
    return text.str();
}

const std::string flat = "hamiltonian = \"flat\"";
/// A block of glass whose upper face is the plane z = 0.
const std::string block = R"([[object]]
name = "block"
shape = "box"
min = [-50, -50, -50]
max = [50, 50, 0]
material = "boundary"
interior = "glass"
)";
const std::string ball = R"([[object]]
name = "ball"
shape = "sphere"
center = [0, 0, 0]
radius = 1
material = "boundary"
interior = "glass"
)";

/// Returns the reflectance of Fresnel's formulas in terms of the angles: the mean of sin²(a − b)/sin²(a + b) and
/// tan²(a − b)/tan²(a + b).
double fresnel_by_angles(double from, double to, double angle) {
    const double refracted = std::asin(from / to * std::sin(angle));
    if (angle == 0) return std::pow((from - to) / (from + to), 2);
    const double s = std::sin(angle - refracted) / std::sin(angle + refracted),
                 t = std::tan(angle - refracted) / std::tan(angle + refracted);
    return 0.5 * (s * s + t * t);
}

/// Angles of incidence in degrees.
const std::vector<double> angles{0, 1e-4, 5, 15, 30, 41, 45, 60, 75, 85, 89, 89.9};

TEST_P(Surfaces, PlanesRefractAndReflect) {
    const double index = 1.5;
    for (const bool from_inside : {false, true}) {
        const double from = from_inside ? index : 1, to = from_inside ? 1 : index, up = from_inside ? 1 : -1;
        std::vector<RayInput> rays;
        for (const double degrees : angles) {
            const double a = degrees * pi / 180;
            rays.push_back({{-std::sin(a), 0, -up * std::cos(a)}, {std::sin(a), 0, up * std::cos(a)}});
        }
        const Traced traced = trace_rays(scene_with(flat, uniform(index), block), rays, 1);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            SCOPED_TRACE(testing::Message() << angles[i] << " degrees, from inside: " << from_inside);
            const double a = angles[i] * pi / 180, sine = from / to * std::sin(a);
            const double* v = traced.ends[i].v;
            EXPECT_EQ(traced.paths[i].bounces, 1u);
            const double reflected = sine < 1 ? fresnel_by_angles(from, to, a) : 1;
            if (reflected > 0.5) {
                EXPECT_EQ(traced.paths[i].medium, from_inside ? 1u : 0u);
                EXPECT_NEAR(v[0], std::sin(a), 1e-12);
                EXPECT_NEAR(v[2], -up * std::cos(a), 1e-12);
                EXPECT_NEAR(traced.paths[i].weight[0], reflected, 1e-9);
            } else {
                EXPECT_EQ(traced.paths[i].medium, from_inside ? 0u : 1u);
                EXPECT_NEAR(v[0], sine, 1e-12);
                EXPECT_NEAR(v[2], up * std::sqrt(1 - sine * sine), 1e-12);
                EXPECT_NEAR(traced.paths[i].weight[1], (1 - reflected) * std::pow(from / to, 2), 1e-9);
            }
        }
    }
}

TEST_P(Surfaces, TotalReflectionBeginsAtTheCriticalAngle) {
    const double index = 1.5, critical = std::asin(1 / index);
    std::vector<RayInput> rays;
    const std::vector<double> offsets{-1e-3, -1e-6, -1e-9, 1e-9, 1e-6, 1e-3};
    for (const double offset : offsets)
        rays.push_back({{0, 0, -0.5}, {std::sin(critical + offset), 0, std::cos(critical + offset)}});
    const std::string transmitting = block + "fresnel = \"transmit\"\n";
    const Traced traced = trace_rays(scene_with(flat, uniform(index), transmitting), rays, 1);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        SCOPED_TRACE(offsets[i]);
        EXPECT_EQ(traced.paths[i].medium, offsets[i] < 0 ? 0u : 1u);
        const double sine = index * std::sin(critical + offsets[i]);
        if (offsets[i] < 0) EXPECT_NEAR(traced.ends[i].v[2], std::sqrt((1 - sine) * (1 + sine)), 1e-9);
        else EXPECT_NEAR(traced.ends[i].v[2], -std::cos(critical + offsets[i]), 1e-12);
        EXPECT_NEAR(traced.paths[i].weight[2], offsets[i] < 0 ? index * index : 1, 1e-12);
    }
}

/// A ray in the plane y = 0 through a ball, from height h parallel to +x. It is deflected by 2(b − a), where a is the
/// angle of incidence and b that of refraction, and passes the axis at the distance sin(a)/sin(2(a − b)) from the
/// centre.
TEST_P(Surfaces, BallLensHasTheFocusAndTheAberrationOfTheory) {
    const double index = 1.5;
    std::vector<RayInput> rays;
    std::vector<double> heights;
    for (int i = 1; i < 20; ++i) heights.push_back(0.05 * i);
    heights.push_back(1e-5);
    for (const double h : heights) rays.push_back({{-5, 0, h}, {1, 0, 0}});
    const Traced traced = trace_rays(scene_with(flat, uniform(index), ball + "fresnel = \"transmit\"\n"), rays, 2);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        SCOPED_TRACE(heights[i]);
        const double a = std::asin(heights[i]), b = std::asin(heights[i] / index);
        const RayEnd& end = traced.ends[i];
        ASSERT_EQ(end.status, Status::escaped);
        EXPECT_EQ(traced.paths[i].bounces, 2u);
        EXPECT_EQ(traced.paths[i].medium, 0u);
        EXPECT_NEAR(std::atan2(-end.v[2], end.v[0]), 2 * (a - b), 1e-12);
        const double focus = end.q[0] - end.q[2] * end.v[0] / end.v[2];
        const double expected = std::sin(a) / std::sin(2 * (a - b));
        EXPECT_NEAR(focus, expected, 1e-9 * std::max(1.0, 1e-3 / heights[i]));
        EXPECT_NEAR(traced.paths[i].weight[0], 1, 1e-14);
    }
    EXPECT_NEAR(index / (2 * (index - 1)), 1 / std::sin(2 * (1e-5 - 1e-5 / index)) * 1e-5, 1e-9);  // paraxial focus
}

/// A rod of graded glass, N² = n0²(1 − α² r²), with plane faces at z = 0 and z = L. Inside, r = r0 cos(n0 α λ) and
/// z = λ N(r0) for a ray that enters parallel to the axis.
TEST_P(Surfaces, RodOfGradedGlassWithFacesFocuses) {
    const double n0 = 1.6, alpha = 0.4, quarter = pi / (2 * n0 * alpha);
    for (const double length : {n0 * quarter, 0.7 * n0 * quarter, 2.3 * n0 * quarter}) {
        std::ostringstream rod;
        rod.precision(17);
        rod << "[[object]]\nname = \"rod\"\nshape = \"box\"\nmin = [-1.5, -1.5, 0]\nmax = [1.5, 1.5, " << length
            << "]\nmaterial = \"boundary\"\ninterior = \"glass\"\nfresnel = \"transmit\"\n";
        std::vector<RayInput> rays;
        const std::vector<double> radii{0, 0.1, 0.3, 0.6, 0.9};
        for (const double r : radii) rays.push_back({{r, 0, -2}, {0, 0, 1}});
        std::ostringstream fiber;
        fiber << "hamiltonian = \"fiber\"\nn0 = " << n0 << "\nalpha = " << alpha;
        const Traced traced = trace_rays(scene_with(flat, fiber.str(), rod.str()), rays, 2);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            SCOPED_TRACE(testing::Message() << "length " << length << ", radius " << radii[i]);
            const double r0 = radii[i], pz = n0 * std::sqrt(1 - alpha * alpha * r0 * r0),
                         phase = n0 * alpha * length / pz;
            const double x = r0 * std::cos(phase), px = -r0 * n0 * alpha * std::sin(phase);  // the exit keeps px
            const RayEnd& end = traced.ends[i];
            ASSERT_EQ(end.status, Status::escaped);
            EXPECT_NEAR(end.v[0], px, 1e-10);
            EXPECT_NEAR(end.q[0] - (end.q[2] - length) * end.v[0] / end.v[2], x, 1e-9);
        }
    }
}

/// A ball of radius 1 with the index N(r) of a fisheye inside, and a step of the index at its surface. The polar angle
/// that a ray with the impact parameter b sweeps inside is 2 ∫ b dr / (r √(N² r² − b²)) from the turning point to 1.
TEST_P(Surfaces, BallWithAStepAndAGradedInteriorTurnsRaysByTheQuadrature) {
    const double n0 = 2.2, radius = 1.7;  // N(1) = 1.634
    const auto index = [&](double r) { return n0 / (1 + r * r / (radius * radius)); };
    const std::string fisheye = "hamiltonian = \"fisheye\"\nn0 = 2.2\nradius = 1.7";
    std::vector<RayInput> rays;
    std::vector<double> impacts{0.1, 0.25, 0.4, 0.55, 0.7, 0.85, 0.95};
    for (const double b : impacts) rays.push_back({{-5, 0, b}, {1, 0, 0}});
    const Traced traced = trace_rays(scene_with(flat, fisheye, ball + "fresnel = \"transmit\"\n"), rays, 2);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const double b = impacts[i];
        // N(r) r increases up to r = 1.7, so the turning point is unique.
        double low = 0, high = 1;
        while (0.5 * (low + high) > low && 0.5 * (low + high) < high) {
            const double middle = 0.5 * (low + high);
            (index(middle) * middle < b ? low : high) = middle;
        }
        // With r = r0 + (1 − r0) s², the integrand is smooth. It is summed by the
        // Gauss–Legendre rule with three points, in many intervals.
        const double r0 = high;
        const auto integrand = [&](double s) {
            const double r = r0 + (1 - r0) * s * s, root = std::sqrt(index(r) * r - b) * std::sqrt(index(r) * r + b);
            return 4 * (1 - r0) * s * b / (r * root);
        };
        const int n = 20000;
        double swept = 0;
        for (int k = 0; k < n; ++k) {  // midpoints avoid s = 0, where the integrand is a limit
            const double x = std::sqrt(0.6) / 2;
            swept +=
                (5 * integrand((k + 0.5 - x) / n) + 8 * integrand((k + 0.5) / n) + 5 * integrand((k + 0.5 + x) / n)) /
                (18 * n);
        }
        const double deflection = swept + 2 * std::asin(b) - pi;  // 0 for a straight line
        const RayEnd& end = traced.ends[i];
        SCOPED_TRACE(b);
        ASSERT_EQ(end.status, Status::escaped);
        EXPECT_NEAR(std::remainder(std::atan2(-end.v[2], end.v[0]) - deflection, 2 * pi), 0, 1e-9);
    }
}

/// Returns the text of a vector with all digits.
std::string text_of(const Double3& v) {
    std::ostringstream text;
    text.precision(17);
    text << '[' << v[0] << ", " << v[1] << ", " << v[2] << ']';
    return text.str();
}

/// Returns a square of edge 2·half around a point, perpendicular to a normal.
std::string square(const std::string& name, const Double3& center, const Double3& normal, double half,
                   const std::string& keys) {
    const Double3 n = unit(normal), u = unit(cross(n, std::abs(n[0]) < 0.6 ? Double3{1, 0, 0} : Double3{0, 1, 0})),
                  v = cross(n, u), corner = subtract(center, add(scaled(u, half), scaled(v, half)));
    return "[[object]]\nname = \"" + name + "\"\nshape = \"rectangle\"\norigin = " + text_of(corner) +
           "\nedge_u = " + text_of(scaled(u, 2 * half)) + "\nedge_v = " + text_of(scaled(v, 2 * half)) + '\n' + keys;
}

/// Returns the end of a ray at the given λ in an empty space.
RayEnd end_at(const std::string& isa, const std::string& space, const RayInput& ray, double parameter) {
    Options options;
    options.isa = isa;
    const auto plan = plan_of_text(space + "\n[integrator]\nescape_radius = 100\nrescale = \"none\"\n" + unused_camera,
                                   {}, options, false);
    plan->run.parameter_limit = parameter;
    std::vector<RayEnd> ends;
    trace(*plan, start_rays(*plan, {ray}), ends);
    return ends[0];
}

// A mirror that is normal to a ray sends it back on its path. Near a hole, a mirror at rest is normal to a ray if its
// normal is the momentum in its rest frame: n_i = p_i − p_t g_ti/g_tt. With the metric of Kerr and Schild,
// g_tt = f − 1 and g_ti = −f x_i/r, where f = r_g/r.
TEST_P(Surfaces, MirrorsSendRaysNearAHoleBackToTheirStart) {
    const std::string space = "[space]\nhamiltonian = \"schwarzschild\"\nrg = 1";
    for (const double y : {2.7, 3.2, 5.0})
        for (const double parameter : {4.0, 11.0, 16.0}) {
            SCOPED_TRACE(testing::Message() << "y = " << y << ", mirror at " << parameter);
            const RayInput ray{{8, y, 0.3}, {-1, 0.05, 0.02}};
            const RayEnd at = end_at(GetParam(), space, ray, parameter);
            ASSERT_EQ(at.status, Status::step_limit);
            const Double3 q{at.q[0], at.q[1], at.q[2]};
            const double r = length(q), f = 1 / r;
            Double3 normal;
            for (std::size_t k = 0; k < 3; ++k) normal[k] = at.p[k] + at.pt * f * q[k] / (r * (f - 1));
            const std::string scene = space + "\n[integrator]\nescape_radius = 100\n" +
                                      square("mirror", q, normal, 0.05, "material = \"mirror\"\n") +
                                      square("start", ray.position, ray.direction, 0.05, "");
            const Traced traced = trace_rays(scene, {ray}, 1);
            ASSERT_EQ(traced.ends[0].status, Status::hit);
            EXPECT_EQ(traced.ends[0].surface, 1u);
            EXPECT_EQ(traced.paths[0].bounces, 1u);
            for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(traced.ends[0].q[k], ray.position[k], 1e-9);
            const Double3 d = unit(ray.direction);
            for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(traced.ends[0].v[k], -d[k], 1e-9);
        }
}

/// Spaces around a ball of glass, with the position of the ball, which is about one unit from the rays' start.
struct Outside {
    const char* name;
    const char* space;
    Double3 center;
};

const Outside outsides[] = {
    {"flat", "hamiltonian = \"flat\"", {0, 0, 0}},
    {"schwarzschild", "hamiltonian = \"schwarzschild\"\nrg = 1", {5, 0.4, 0.3}},
    {"mirage", "hamiltonian = \"mirage\"", {0, 0, 0}},
    {"shimmer", "hamiltonian = \"shimmer\"", {0.2, 0.1, 0}},
    {"gradient", "hamiltonian = \"gradient\"\nn0 = 1.4\ng = 0.1", {0, 0, 0}},
    {"fisheye", "hamiltonian = \"fisheye\"\nn0 = 2\nradius = 3", {0.5, 0, 0}},
    {"fiber", "hamiltonian = \"fiber\"\nn0 = 1.5\nalpha = 0.1", {0, 0, 0}},
    {"layer", "hamiltonian = \"layer\"\nn_below = 1.3\nn_above = 1\nthickness = 0.5", {0, 0, 0.2}},
    {"duct", "hamiltonian = \"duct\"", {0, 0, 0.6}},
    {"wormhole", "hamiltonian = \"wormhole\"\nthroat = 1", {4, 0.2, 0.1}},
    {"luneburg", "hamiltonian = \"luneburg\"\nradius = 2", {0.1, 0.2, 0}},
    {"anisotropic", "hamiltonian = \"formula\"\nH = \"0.5*(px^2 + 1.3*py^2 + 0.8*pz^2 + 0.2*px*py - 1)\"", {0, 0, 0}},
    {"quartic", "hamiltonian = \"formula\"\nH = \"0.25*(px^4 + py^4 + pz^4 + px^2*py^2) - 0.25\"", {0, 0, 0}},
};

// A ray passes through a ball of glass to a screen. A ray that is sent back from the screen, with the opposite
// direction of dq/dλ, passes through the same points, because H of all these spaces is even in p (up to a gradient,
// around a hole without spin). It arrives at a screen through the first start. Around a spinning hole, the ray that is
// sent back takes another way: the hole drags it in the same sense as the first one.
TEST_P(Surfaces, RaysThroughGlassAreReversible) {
    for (const Outside& outside : outsides)
        for (const double height : {0.05, 0.12}) {
            SCOPED_TRACE(testing::Message() << outside.name << " at " << height);
            const RayInput ray{add(outside.center, {-0.8, height, 0.04}), {1, 0.03, -0.02}};
            std::ostringstream sphere;
            sphere
                << "[[object]]\nname = \"ball\"\nshape = \"sphere\"\nradius = 0.3\nmaterial = \"boundary\"\ninterior = "
                   "\"glass\"\nfresnel = \"transmit\"\ncenter = "
                << text_of(outside.center) << '\n';
            const std::string screens = square("far", add(outside.center, {0.9, 0, 0}), {1, 0.1, 0}, 1.5, "") +
                                        square("near", ray.position, {1, 0, 0.1}, 1.5, "");
            const std::string scene = scene_with(outside.space, uniform(1.7), sphere.str() + screens);
            const Traced there = trace_rays(scene, {ray}, 4);
            ASSERT_EQ(there.ends[0].status, Status::hit) << int(there.ends[0].failure);
            ASSERT_EQ(there.ends[0].surface, 1u);
            EXPECT_EQ(there.paths[0].bounces, 2u);
            const RayEnd& end = there.ends[0];
            const Traced back =
                trace_rays(scene, {{{end.q[0], end.q[1], end.q[2]}, {-end.v[0], -end.v[1], -end.v[2]}}}, 4);
            ASSERT_EQ(back.ends[0].status, Status::hit);
            ASSERT_EQ(back.ends[0].surface, 2u);
            EXPECT_EQ(back.paths[0].bounces, 2u);
            for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(back.ends[0].q[k], ray.position[k], 1e-10);
        }
}

}  // namespace
}  // namespace kagero::test
