// Compares the integrals along rays, the action and the time, with closed forms: Shapiro's delay of a black hole, the
// optical path in a fibre and in Maxwell's fisheye, and straight rays. Every instruction set and strategy is tested.
#include "tests/support/plan_fixture.h"

#include "error.h"
#include "render/render.h"

#include <boost/math/quadrature/tanh_sinh.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kagero::test {
namespace {

constexpr double tolerance = 1e-9, pi = std::numbers::pi;

constexpr const char* camera = "[camera]\nposition = [0, 0, 9]\nlook_at = [0, 0, 0]\n[film]\nsize = [4, 4]\n";
const std::string black_hole = std::string(camera) + "[space]\nhamiltonian = \"schwarzschild\"\nrg = 1\n";
const std::string black_hole_formula =
    std::string(camera) +
    "[space]\nhamiltonian = \"formula\"\n"
    "H = \"0.5*(px^2 + py^2 + pz^2 - pt^2) - 0.5/R*(pt + (x*px + y*py + z*pz)/R)^2\"\nlength_scale = \"R/2\"\n"
    "[space.constants]\npt = 1\n[space.let]\nR = \"sqrt(x^2 + y^2 + z^2)\"\n";
const std::string fibre = std::string(camera) + "[space]\nhamiltonian = \"fiber\"\nn0 = 1.5\nalpha = 0.4\n";
const std::string fibre_formula =
    std::string(camera) +
    "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - 2.25*(1 - 0.16*(x^2 + y^2)))\"\n";
const std::string fisheye = std::string(camera) + "[space]\nhamiltonian = \"fisheye\"\nn0 = 1.7\nradius = 1.3\n";
const std::string fisheye_formula =
    std::string(camera) +
    "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - (1.7/(1 + (x^2 + y^2 + z^2)/1.69))^2)\"\n";

/// Methods with steps for which their error is below the tolerance in all spaces of this test.
const std::vector<Overrides> media_methods{
    {},
    {"integrator.rescale=none"},
    {"integrator.method=dp85", "integrator.tolerance=1e-11", "integrator.rescale=\"1 + 0.5*r^2\""},
    {"integrator.method=gauss8", "integrator.step=0.02"},
    {"integrator.method=gauss12", "integrator.step=0.1", "integrator.rescale=\"1 + 0.5*r^2\""},
    {"integrator.method=verner9", "integrator.step=0.05"},
    {"integrator.method=kahan-li8", "integrator.step=0.05"},
    {"integrator.method=srkn14", "integrator.step=0.05"},
    {"integrator.method=rk4", "integrator.step=0.002"},
};

struct Kernel {
    std::string isa, strategy;
};
void PrintTo(const Kernel& kernel, std::ostream* out) { *out << kernel.isa << ' ' << kernel.strategy; }
std::vector<Kernel> all_kernels() {
    std::vector<Kernel> kernels;
    for (const std::string& isa : supported_isas())
        for (const char* strategy : {"scalar", "packet"}) kernels.push_back({isa, strategy});
    return kernels;
}

std::string text_of(const Overrides& overrides) {
    std::string text;
    for (const Override& key : overrides) text += key.text + ' ';
    return text;
}

class PathIntegrals : public testing::TestWithParam<Kernel> {
protected:
    static Options options(bool with_time) {
        Options chosen = with_strategy(GetParam().strategy);
        chosen.isa = GetParam().isa;
        chosen.action = true;
        chosen.time = with_time;
        return chosen;
    }
    static std::vector<RayEnd> ends_of(const Plan& plan, const std::vector<RayInput>& rays) {
        std::vector<RayEnd> ends;
        trace(plan, start_rays(plan, rays, {}), ends);
        return ends;
    }
    /// Expects that the action of every ray that ends with `status` is the closed form of the ray.
    template <class ClosedForm>
    static void expect_action(const std::string& scene, const Overrides& overrides, const std::vector<RayInput>& rays,
                              Status status, double parameter_limit, const ClosedForm& closed_form) {
        SCOPED_TRACE(text_of(overrides) + scene);
        const auto plan = plan_of_text(scene, overrides, options(false), false);
        plan->run.parameter_limit = parameter_limit;
        const std::vector<RayEnd> ends = ends_of(*plan, rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_EQ(ends[i].status, status) << "ray " << i;
            EXPECT_NEAR(ends[i].action, closed_form(start_rays(*plan, {rays[i]}, {})[0], ends[i]), tolerance)
                << "ray " << i;
        }
    }
};
INSTANTIATE_TEST_SUITE_P(Kernels, PathIntegrals, testing::ValuesIn(all_kernels()));

constexpr double no_limit = std::numeric_limits<double>::infinity();

double length_of(const double (&q)[3]) { return std::hypot(q[0], q[1], q[2]); }

/// Returns the Schwarzschild time in which light with p_t = 1 passes from q inward to its turning point and out again
/// to the radius r_end, for r_g = 1: ∫ dr / ((1 − 1/r) √(1 − (1 − 1/r) b²/r²)) (Shapiro 1964). With r = r_min + x² the
/// integrand has no singularity.
double travel_time(const RayStart& start, double r_end) {
    const auto& q = start.q;
    const auto& p = start.p;
    const long double b = std::hypot(q[1] * p[2] - q[2] * p[1], q[2] * p[0] - q[0] * p[2], q[0] * p[1] - q[1] * p[0]);
    const long double least = 2 * b / std::sqrt(3.0L) * std::cos(std::acos(-1.5L * std::sqrt(3.0L) / b) / 3);
    const auto integrand = [&](long double x) {
        const long double r = least + x * x;
        return 2 * r * std::sqrt(r) / ((1 - 1 / r) * std::sqrt(r * r + least * r + least * least - b * b));
    };
    boost::math::quadrature::tanh_sinh<long double> quadrature;
    double sum = 0;
    for (const double r : {length_of(q), r_end})
        sum += double(quadrature.integrate(integrand, 0.0L, std::sqrt(r - least)));
    return sum;
}

// The time of the outgoing Kerr–Schild coordinates is t = t_S − r_g ln(r/r_g − 1). A ray is followed backward, so the
// integral is negative. The action is the negative of p_t times the time, because H is quadratic in (p, p_t).
TEST_P(PathIntegrals, TimeIsThatOfShapirosDelay) {
    const std::vector<RayInput> rays{{{-20, 3, 0}, {1, 0, 0}}, {{-40, 5, 2}, {1, 0, 0}}, {{-10, 2, 7}, {1, 0, 0.2}}};
    const std::vector<Overrides> methods{
        {},
        {"integrator.rescale=none"},
        {"integrator.rescale=\"sqrt(r)\""},
        {"integrator.method=gauss8", "integrator.step=0.1"},
        {"integrator.method=gauss12", "integrator.step=0.2", "integrator.rescale=none"},
        {"integrator.method=verner9", "integrator.step=0.1"},
        {"integrator.method=rkf78", "integrator.tolerance=1e-12"},
        {"integrator.method=kahan-li8", "integrator.step=0.05"},
        {"integrator.method=ks-kahan-li8", "integrator.step=0.1", "integrator.rescale=none"},
        {"integrator.method=orbit-srkn14", "integrator.step=0.03"},
    };
    for (const std::string& scene : {black_hole, black_hole_formula})
        for (const Overrides& overrides : methods) {
            const std::string text = text_of(overrides);
            const bool needs_split = text.find("ks-") != std::string::npos || text.find("orbit") != std::string::npos;
            if (needs_split && scene == black_hole_formula) continue;
            SCOPED_TRACE(text + scene);
            const auto plan = plan_of_text(scene, overrides, options(true), false);
            const std::vector<RayEnd> ends = ends_of(*plan, rays);
            for (std::size_t i = 0; i < rays.size(); ++i) {
                ASSERT_EQ(ends[i].status, Status::escaped);
                const RayStart start = start_rays(*plan, {rays[i]}, {})[0];
                const double r_start = length_of(start.q), r_end = length_of(ends[i].q);
                const double expected = -travel_time(start, r_end) - std::log((r_end - 1) / (r_start - 1));
                EXPECT_NEAR(ends[i].time, expected, tolerance) << "ray " << i;
                EXPECT_NEAR(ends[i].action, -expected, tolerance) << "ray " << i;
            }
        }
}

// Transversely, a ray in the fibre is a harmonic oscillation with the frequency ω = n0 α in λ. Over a quarter of a
// period, ∫ (p0 cos ωλ − ω q0 sin ωλ)² dλ = (p0² + ω² q0²) λ/2 − p0 q0.
TEST_P(PathIntegrals, ActionOverAQuarterPitchOfAFibre) {
    const double omega = 1.5 * 0.4, quarter = pi / (2 * omega);
    const std::vector<RayInput> rays{
        {{0, 0, 0}, {0.3, 0.1, 1}}, {{0.4, 0.2, 0}, {0.1, 0.2, 1}}, {{0, 0, 1}, {1, 0, 9}}};
    const auto closed_form = [&](const RayStart& start, const RayEnd&) {
        double sum = start.p[2] * start.p[2] * quarter;
        for (const int k : {0, 1})
            sum += (start.p[k] * start.p[k] + omega * omega * start.q[k] * start.q[k]) * quarter / 2 -
                   start.p[k] * start.q[k];
        return sum;
    };
    for (const std::string& scene : {fibre, fibre_formula})
        for (Overrides overrides : media_methods) {
            const std::string text = text_of(overrides);
            if (text.find("rescale=\"") != std::string::npos) continue;  // λ has no limit then
            overrides.push_back("integrator.rescale=none");
            overrides.push_back("integrator.symmetry=none");
            expect_action(scene, overrides, rays, Status::step_limit, quarter, closed_form);
        }
}

// The optical path from a point on the sphere |q| = R to its image −q is π n0 R/2 for all rays. The image lies on a
// rectangle that the rays hit.
TEST_P(PathIntegrals, ActionOverAHalfCircleOfTheFisheye) {
    const std::string screen =
        "[[object]]\nshape = \"rectangle\"\norigin = [-1.3, -4, -4]\nedge_u = [0, 8, 0]\nedge_v = [0, 0, 8]\n";
    std::vector<RayInput> rays;
    for (int i = 0; i < 11; ++i) rays.push_back({{1.3, 0, 0}, {-0.5 - 0.1 * i, std::cos(i), std::sin(i)}});
    const auto closed_form = [&](const RayStart&, const RayEnd&) { return pi / 2 * 1.7 * 1.3; };
    for (const std::string& scene : {fisheye, fisheye_formula})
        for (Overrides overrides : media_methods) {
            if (text_of(overrides).find("srkn") != std::string::npos) overrides.push_back("integrator.rescale=none");
            expect_action(scene + screen, overrides, rays, Status::hit, no_limit, closed_form);
        }
}

// Stereographic projection maps the rays of the fisheye to great circles. The optical path between two points is n0 R/2
// times the angle between their images on the sphere.
TEST_P(PathIntegrals, ActionInTheOrbitPlaneOfTheFisheye) {
    const std::string screen =
        "[[object]]\nshape = \"rectangle\"\norigin = [-0.5, -4, -4]\nedge_u = [0, 8, 0]\nedge_v = [0, 0, 8]\n";
    std::vector<RayInput> rays;
    for (int i = 0; i < 11; ++i) rays.push_back({{1.3, 0.1, 0}, {-0.5 - 0.1 * i, std::cos(i), std::sin(i)}});
    const auto closed_form = [](const RayStart& a, const RayEnd& b) {
        const double square = 1.3 * 1.3, distance = std::hypot(b.q[0] - a.q[0], b.q[1] - a.q[1], b.q[2] - a.q[2]);
        const double scale = (square + std::pow(length_of(a.q), 2)) * (square + std::pow(length_of(b.q), 2));
        return 1.7 * 1.3 * std::asin(1.3 * distance / std::sqrt(scale));
    };
    for (const char* method : {"orbit-srkn6", "orbit-srkn11", "orbit-srkn14"})
        expect_action(fisheye + screen, {std::string("integrator.method=") + method, "integrator.step=0.03"}, rays,
                      Status::hit, no_limit, closed_form);
}

// In a uniform space, the action is the index times the length of the ray, whether the ray hits a sphere or a
// rectangle, or escapes.
TEST_P(PathIntegrals, ActionOfStraightRays) {
    const std::string objects =
        "[[object]]\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\n"
        "[[object]]\nshape = \"rectangle\"\norigin = [2, -9, -9]\nedge_u = [0, 18, 0]\nedge_v = [0, 0, 18]\n";
    const std::vector<RayInput> rays{
        {{-3, 0.1, 0.2}, {1, 0.05, 0.02}}, {{-3, 0.9, 0.6}, {1, 0, 0.02}}, {{-3, 2, 1}, {-1, 0.3, 0.1}}};
    const std::vector<std::string> spaces{"hamiltonian = \"flat\"\n", "hamiltonian = \"schwarzschild\"\nrg = 0\n",
                                          "hamiltonian = \"gradient\"\nn0 = 1.5\ng = 0\n",
                                          "hamiltonian = \"uniform\"\n",
                                          "hamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - 2.25)\"\n"};
    for (const std::string& space : spaces) {
        SCOPED_TRACE(space);
        const double index = space.find("flat") != space.npos || space.find("rg = 0") != space.npos ? 1 : 1.5;
        const auto plan = plan_of_text(camera + ("[space]\n" + space) + objects, {}, options(false), false);
        const std::vector<RayEnd> ends = ends_of(*plan, rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const Double3& from = rays[i].position;
            const double length = std::hypot(ends[i].q[0] - from[0], ends[i].q[1] - from[1], ends[i].q[2] - from[2]);
            EXPECT_EQ(ends[i].status, i < 2 ? Status::hit : Status::escaped);
            EXPECT_NEAR(ends[i].action, index * length, 1e-13 * index * length) << "ray " << i;
        }
    }
}

// The rays themselves must be the same, bit for bit, whether integrals are requested or not.
TEST_P(PathIntegrals, LeaveRaysUnchanged) {
    const std::string sphere = "[[object]]\nshape = \"sphere\"\ncenter = [9, 1, 0]\nradius = 2\n";
    const std::vector<RayInput> rays{{{-20, 3, 0}, {1, 0, 0}}, {{-20, 5, 1}, {1, 0, 0}}, {{-9, 1, 0}, {1, 0, 0}}};
    for (const char* method : {"dp85", "gauss8", "suzuki4-nine"}) {
        const Overrides overrides{std::string("integrator.method=") + method};
        const auto with = plan_of_text(black_hole + sphere, overrides, options(true), false);
        auto without = *with;
        without.run.outputs &= ~output_integrals;
        const std::vector<RayEnd> a = ends_of(*with, rays), b = ends_of(without, rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            EXPECT_EQ(a[i].status, b[i].status);
            EXPECT_EQ(a[i].steps, b[i].steps);
            EXPECT_EQ(a[i].gradients, b[i].gradients);
            EXPECT_EQ(a[i].parameter, b[i].parameter);
            for (int k = 0; k < 3; ++k) {
                EXPECT_EQ(a[i].q[k], b[i].q[k]);
                EXPECT_EQ(a[i].p[k], b[i].p[k]);
            }
            EXPECT_EQ(b[i].action, 0);
        }
    }
}

// The point of a path at λ = 2.5 k must be the end of the ray with this limit of λ, with the same integrals.
TEST_P(PathIntegrals, BelongToThePointsAtEvenIntervals) {
    const std::vector<RayInput> rays{{{-20, 3, 0}, {1, 0, 0}}, {{-8, 4, 1}, {1, 0, 0}}};
    const auto limited = plan_of_text(black_hole, {"integrator.rescale=none"}, options(true), false);
    for (const Overrides& overrides : std::vector<Overrides>{{},
                                                             {"integrator.rescale=none"},
                                                             {"integrator.method=gauss12", "integrator.step=0.1"},
                                                             {"integrator.method=verner9", "integrator.step=0.1"}}) {
        SCOPED_TRACE(text_of(overrides));
        const auto plan = plan_of_text(black_hole, overrides, options(true), false);
        plan->run.path_interval = 2.5;
        std::vector<RayEnd> ends;
        const std::vector<PathPoint> points = trace_paths(*plan, start_rays(*plan, rays, {}), ends);
        std::size_t expected_points = 0;
        for (const RayEnd& end : ends) expected_points += std::size_t(end.parameter / 2.5) + 1;
        EXPECT_EQ(points.size(), expected_points);
        for (const PathPoint& point : points) {
            EXPECT_DOUBLE_EQ(point.parameter, 2.5 * point.step);
            if (point.step % 5 != 1) continue;
            limited->run.parameter_limit = point.parameter;
            const RayEnd end = ends_of(*limited, rays)[point.ray];
            for (int k = 0; k < 3; ++k) {
                EXPECT_NEAR(point.q[k], end.q[k], tolerance);
                EXPECT_NEAR(point.p[k], end.p[k], tolerance);
                EXPECT_NEAR(point.v[k], end.v[k], tolerance);
            }
            EXPECT_NEAR(point.action, end.action, tolerance);
            EXPECT_NEAR(point.time, end.time, tolerance);
        }
    }
}

// Each pixel of the layers is the mean over its rays, in every sampling. `trace` gives the same numbers.
TEST_P(PathIntegrals, AreLayersOfPictures) {
    const std::string text = black_hole + "[integrator]\nescape_radius = 12\n";
    for (const char* spp : {"1", "3"}) {
        const Overrides overrides{std::string("film.spp=") + spp, "film.layers=[\"color\", \"time\", \"action\"]",
                                  "film.size=[6, 5]"};
        const auto plan = plan_of_text(text, overrides, options(false));
        Film film = film_of(*plan);
        render_with_errors(*plan, film, {});
        Plan list = *plan;
        list.run.outputs |= output_action | output_time;
        for (std::uint32_t i = 0; i < 30; ++i) {
            const Tile pixel{i % 6, i / 6, i % 6 + 1, i / 6 + 1};
            RayList rays;
            list_rays(*plan, pixel, rays);
            std::vector<RayEnd> ends;
            trace(list, rays.starts, ends);
            double action = 0, time = 0;
            for (const RayEnd& end : ends) {
                action += end.action / double(ends.size());
                time += end.time / double(ends.size());
            }
            EXPECT_FLOAT_EQ(*film.pixel("action", pixel.x0, pixel.y0), float(action)) << i;
            EXPECT_FLOAT_EQ(*film.pixel("time", pixel.x0, pixel.y0), float(time)) << i;
        }
    }
}

// Sums in float are compensated, so that many steps lose no accuracy.
TEST_P(PathIntegrals, AreCompensatedInFloat) {
    Options chosen = options(false);
    chosen.precision = Precision::float32;
    const auto plan = plan_of_text(fibre, {"integrator.method=srkn6", "integrator.step=0.002"}, chosen, false);
    const RayEnd end = ends_of(*plan, {{{0, 0, 0}, {0, 0, 1}}})[0];
    EXPECT_GT(end.steps, 10000u);
    EXPECT_NEAR(end.action, 2.25 * end.parameter, 1e-6 * 75);
}

TEST(Time, IsRefusedWhereHDoesNotDependOnPt) {
    Options options;
    options.time = true;
    for (const std::string& scene : {fibre, fibre_formula}) {
        EXPECT_THROW(plan_of_text(scene, {}, options, false), InputError);
        EXPECT_THROW(plan_of_text(scene, {"film.layers=[\"time\"]"}), InputError);
        EXPECT_NO_THROW(plan_of_text(scene, {"film.layers=[\"action\"]"}));
    }
    EXPECT_NO_THROW(plan_of_text(black_hole_formula, {}, options, false));
}

}  // namespace
}  // namespace kagero::test
