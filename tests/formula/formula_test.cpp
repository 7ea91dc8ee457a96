// Tests of rays in spaces whose Hamiltonian is a formula. They are compared with the rays of built-in spaces with the
// same Hamiltonian.
#include "tests/formula/formula_scene.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kagero::test {
namespace {

/// A built-in space and a formula with the same Hamiltonian.
struct SpacePair {
    const char *name, *built_in, *formula;
    double origin[3];                 ///< Start of the rays.
    const char* escape_radius = "9";  ///< It is smaller if rays would otherwise take thousands of steps.
};

/// H of a formula is copied from the header of the built-in Hamiltonian. A formula cannot describe the second sheet of
/// `wormhole`, the discontinuity of `luneburg` or the random index of `shimmer`.
const SpacePair pairs[] = {
    {"flat", "[space]\nhamiltonian = \"flat\"\n",
     "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - 1)\"\n", {-3, 0.5, 0.25}},
    {"schwarzschild", "[space]\nhamiltonian = \"schwarzschild\"\nrg = 0.5\n",
     "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - pt^2) - 0.5*(rg/r)*u^2\"\n"
     "capture = \"r - rg\"\n[space.constants]\nrg = 0.5\npt = 1\n"
     "[space.let]\nr = \"sqrt(x^2 + y^2 + z^2)\"\nu = \"pt + (x*px + y*py + z*pz)/r\"\n",
     {-7, 0.5, 0.25}},
    {"mirage", "[space]\nhamiltonian = \"mirage\"\n", mirage_formula, {0, 0, 0}},
    {"fisheye", "[space]\nhamiltonian = \"fisheye\"\nn0 = 2\nradius = 1\n",
     "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - (2/(1 + x^2 + y^2 + z^2))^2)\"\n",
     {-1, 0.1, 0}, "1.5"},
    {"fiber", "[space]\nhamiltonian = \"fiber\"\nn0 = 1.5\nalpha = 0.3\n",
     "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - (1.5^2)*(1 - (0.3^2)*(x^2 + y^2)))\"\n",
     {0.3, 0.1, 0}, "1.5"},
    {"gradient", "[space]\nhamiltonian = \"gradient\"\n",
     "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - (1 - 0.1*z))\"\n", {-3, 0.5, 0.25}},
    {"layer", "[space]\nhamiltonian = \"layer\"\n",
     "[space]\nhamiltonian = \"formula\"\n"
     "H = \"0.5*(px^2 + py^2 + pz^2 - (0.5*(1.5^2 + 1) + 0.5*(1 - 1.5^2)*tanh(z/0.1)))\"\n"
     "length_scale = \"0.1*max(0.1, abs(z))\"\n", {-3, 0.5, -1}},
    {"duct", "[space]\nhamiltonian = \"duct\"\n",
     "[space]\nhamiltonian = \"formula\"\nH = \"0.5*n*(px^2 + py^2 + pz^2)\"\nH0 = 0.5\n"
     "[space.let]\nn = \"0.85 + 0.3*(z^2 + 1e-30)^1.5 + 0.03*cos(3*pi*x)\"\n", {0, 0, 0}},
    {"kerr", "[space]\nhamiltonian = \"kerr\"\nmass = 0.25\nspin = 0.6\n",
     "[space]\nhamiltonian = \"formula\"\n"
     "H = \"0.5*(px^2 + py^2 + pz^2 - pt^2) - 0.5*f*(pt + lx*px + ly*py + z/r*pz)^2\"\n"
     "[space.constants]\npt = 1\nM = 0.25\na = 0.15\n"
     "[space.let]\ns = \"x^2 + y^2 + z^2 - a^2\"\nr = \"sqrt(0.5*(s + sqrt(s^2 + 4*a^2*z^2)))\"\n"
     "f = \"2*M*r^3/(r^4 + a^2*z^2)\"\nlx = \"(r*x - a*y)/(r^2 + a^2)\"\nly = \"(r*y + a*x)/(r^2 + a^2)\"\n",
     {-7, 0.5, 0.25}},
};

bool is_built(const std::string& name) {
    const Catalogue c = catalogue("auto");
    for (std::uint32_t i = 0; i < c.hamiltonian_count; ++i)
        if (name == c.hamiltonians[i].name) return true;
    return false;
}

void expect_close(const double (&a)[3], const double (&b)[3], double tolerance) {
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(a[k], b[k], tolerance * (1 + std::abs(a[k])));
}

/// The parameter is the instruction set.
class FormulaOn : public testing::TestWithParam<std::string> {};

// The built-in space and the formula have the same H and take the same steps. A few hundred roundings per ray occur in
// a different order. The tolerance of 1e-12, about 4500 machine epsilons, covers them.
TEST_P(FormulaOn, HasTheRaysOfTheBuiltInSpace) {
    for (const SpacePair& pair : pairs) {
        if (!is_built(pair.name)) continue;
        for (const char* method : {"verlet", "gauss8", "gauss4", "rk4", "suzuki4-nine"}) {
            const Overrides overrides{"integrator.rescale=none", std::string("integrator.method=") + method,
                                      "integrator.step=0.05",
                                      std::string("integrator.escape_radius=") + pair.escape_radius};
            for (const char* strategy : {"packet", "scalar"}) {
                SCOPED_TRACE(std::string(pair.name) + ", " + method + ", " + strategy);
                const auto rays = fan(pair.origin);
                const auto a = traced(pair.built_in, overrides, strategy, rays, GetParam());
                const auto b = traced(pair.formula, overrides, strategy, rays, GetParam());
                std::size_t compared = 0;
                for (std::size_t i = 0; i < a.size(); ++i) {
                    // The built-in space can capture a ray before it reaches the horizon; the formula cannot.
                    if (a[i].status == Status::captured) continue;
                    ASSERT_EQ(a[i].status, b[i].status) << i;
                    if (a[i].status != Status::escaped) continue;
                    if (a[i].steps > 450) continue;  // rays that stay near the origin for long magnify roundings
                    const double tolerance = 1e-12;
                    expect_close(a[i].q, b[i].q, tolerance);
                    expect_close(a[i].p, b[i].p, tolerance);
                    expect_close(a[i].v, b[i].v, tolerance);
                    // The space `flat` takes a single step, because its rays are straight.
                    const bool same_steps = pair.name == std::string("flat") || a[i].steps == b[i].steps;
                    EXPECT_TRUE(same_steps) << i;
                    ++compared;
                }
                EXPECT_GE(compared, 10u);
            }
        }
    }
}

// The ray starts at x = 3, where exp(1000 x) overflows to infinity and its reciprocal is 0. On the x axis 1/(y² + z²)
// is infinite. The step bound and the domain must be applied nevertheless.
TEST_P(FormulaOn, AppliesBoundsWhereExponentialsOverflow) {
    const std::vector<RayInput> rays{{{3, 0, 0}, {1, 0, 0}}};
    for (const char* strategy : {"packet", "scalar"}) {
        const auto steps = [&](const char* bound) {
            return traced(straight_space + bound, {"integrator.step=1"}, strategy, rays, GetParam())[0].steps;
        };
        EXPECT_EQ(steps("length_scale = \"0.25 + 1/(1 + exp(1000*x))\"\n"), steps("length_scale = \"0.25\"\n"));
        EXPECT_EQ(steps("length_scale = \"min(0.25, 1/(y^2 + z^2))\"\n"), steps("length_scale = \"0.25\"\n"));
        const RayEnd outside =
            traced(straight_space + "domain = \"1/(1 + exp(1000*(x - 2))) - 0.5\"\n", {}, strategy, rays,
                   GetParam())[0];
        EXPECT_EQ(outside.status, Status::escaped);
        EXPECT_EQ(outside.steps, 0u);
        EXPECT_EQ(outside.q[0], 3);
    }
}

INSTANTIATE_TEST_SUITE_P(EveryIsa, FormulaOn, testing::ValuesIn(supported_isas()),
                         [](const auto& isa) { return isa.param; });

// Camera rays, frequencies and redshifts are compared between a built-in spacetime and the formula with the same H.
TEST(FormulaSpace, HasTheObserversOfTheBuiltInSpacetime) {
    for (const SpacePair& pair : pairs) {
        if (!is_built(pair.name) || (std::string(pair.name) != "kerr" && std::string(pair.name) != "schwarzschild"))
            continue;
        for (const std::string observer : {"static", "coordinate"}) {
            const std::string camera = "[camera]\nposition = [-3, 0.5, 0.25]\nlook_at = [0, 0, 0]\nobserver = \"" +
                                       observer + "\"\n[film]\nsize = [9, 7]\n";
            const auto formula = plan_of_text(pair.formula + camera, {}),
                       built_in = plan_of_text(pair.built_in + camera, {});
            for (std::uint32_t y = 0; y < 7; ++y)
                for (std::uint32_t x = 0; x < 9; ++x) {
                    const CameraRay a = camera_ray(*formula, x + 0.5, y + 0.5),
                                    b = camera_ray(*built_in, x + 0.5, y + 0.5);
                    // The momentum of a light ray is defined up to a factor, which differs between the two spaces.
                    const double scale = a.start.pt / b.start.pt;
                    for (int k = 0; k < 3; ++k)
                        EXPECT_NEAR(a.start.p[k], scale * b.start.p[k], 1e-12) << pair.name << ' ' << observer;
                    EXPECT_NEAR(a.frequency, scale * b.frequency, 1e-12);
                    RayEnd formula_end{}, built_in_end{};
                    formula_end.status = built_in_end.status = Status::escaped;
                    formula_end.pt = a.start.pt;
                    built_in_end.pt = b.start.pt;
                    EXPECT_NEAR(redshift_of(*formula, {&formula_end, &a}), redshift_of(*built_in, {&built_in_end, &b}),
                                1e-12);
                }
        }
        EXPECT_NE(refusal(pair.formula, {"camera.observer=zamo"})
                      .find("possible observers at this position: static, coordinate"),
                  std::string::npos);
    }
}

// If H is quadratic in p, the view contains a map from directions to momenta. The momenta of camera rays, which follow
// from the map, are compared with the momenta that Space::start finds by solving an equation for each direction.
TEST(FormulaSpace, HasACameraMapIfHIsQuadraticInP) {
    const std::string quadratic =
        "[space]\nhamiltonian = \"formula\"\nH = \"px^2 + 0.5*(py^2 + pz^2) + 0.3*px*py + 0.2*px*x - 0.1*pz\"\nH0 = "
        "0.5\n";
    const std::string camera =
        "[camera]\nposition = [-3, 0.5, 0.25]\nlook_at = [0, 0, 0]\nobserver = \"coordinate\"\n[film]\nsize = [9, 7]\n";
    const auto plan = plan_of_text(quadratic + camera, {});
    EXPECT_FALSE(plan->view.solves_each_direction);
    for (std::uint32_t y = 0; y < 7; ++y)
        for (std::uint32_t x = 0; x < 9; ++x) {
            const RayStart mapped = pixel_ray_start(*plan, x, y);
            Double3 d;
            for (std::size_t k = 0; k < 3; ++k)
                d[k] = plan->view.camera.corner[k] + (x + 0.5) * plan->view.camera.right[k] +
                       (y + 0.5) * plan->view.camera.down[k];
            const RayStart solved = plan->scene->space.start(plan->view.camera.position, d);
            expect_close(mapped.p, solved.p, 1e-12);
        }
    const auto quartic =
        plan_of_text("[space]\nhamiltonian = \"formula\"\nH = \"(px^2 + 2*py^2 + pz^2)^2 - 1\"\n" + view_text, {});
    EXPECT_TRUE(quartic->view.solves_each_direction);
}

// All lengths of the scene are multiplied by 1e11. The ray ends, divided by that factor, must stay the same.
TEST(FormulaSpace, DoesNotDependOnTheUnitOfLength) {
    const auto end_of = [](const std::string& size) {
        const auto plan = plan_of_text(
            "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2) - 0.5*(1.5 - (x^2 + y^2)/L^2)\"\n"
            "constants = {L = " +
                size + "}\n[integrator]\nmethod = \"srkn6\"\nstep = 0.01\nescape_radius = 3e" + size.substr(2) +
                "\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\n[film]\nsize = [8, 8]\n",
            {}, with_strategy("scalar"), false);
        const double unit = std::stod(size);
        plan->run.step *= unit;
        std::vector<RayEnd> ends;
        trace(*plan, start_rays(*plan, {{{0.25 * unit, 0, 0}, {0.1, 0.2, 1}}}), ends);
        EXPECT_EQ(ends[0].status, Status::escaped);
        return std::array{ends[0].q[0] / unit, ends[0].q[1] / unit, ends[0].v[0]};
    };
    const auto small = end_of("1e0"), large = end_of("1e11");
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(large[k], small[k], 1e-12);
}

// By default, the built-in medium is rescaled by 1/n. The rescaled H is separable, as srkn6 requires. The scene with
// the formula states this rescaling.
TEST(FormulaSpace, SupportsAMethodThatNeedsTheRescaling) {
    if (!is_built("mirage")) GTEST_SKIP() << "the kernel modules were built without mirage";
    const SpacePair& mirage = pairs[2];
    const auto rays = fan(mirage.origin);
    const Overrides overrides{"integrator.method=srkn6", "integrator.step=0.1", "integrator.escape_radius=9"};
    Overrides rescaled = overrides;
    rescaled.push_back("integrator.rescale=\"1/n\"");
    for (const char* strategy : {"packet", "scalar"}) {
        const auto a = traced(mirage.built_in, overrides, strategy, rays),
                   b = traced(mirage.formula, rescaled, strategy, rays);
        for (std::size_t i = 0; i < a.size(); ++i) {
            ASSERT_EQ(a[i].status, b[i].status);
            expect_close(a[i].q, b[i].q, 1e-12);
            EXPECT_NEAR(a[i].parameter, b[i].parameter, 1e-12 * (1 + a[i].parameter));
        }
    }
    EXPECT_NE(refusal(mirage.formula, overrides).find("not of the form |p|^2/2 + V(q)"), std::string::npos);
}

// The tolerance 1e-9 covers rounding errors that the rays magnify.
TEST(FormulaSpace, HasTheSameRaysInPacketsAndAsSingleRays) {
    const std::string space =
        "[space]\nhamiltonian = \"formula\"\nH = \"0.5*u + 0.1*u^2*tanh(1 + sin(x)*exp(-y^2)) + 0.1*atan2(z, "
        "3)*px*max(x, y)\"\nH0 = 0.5\n"
        "[space.let]\nu = \"px^2 + 1.5*py^2 + pz^2\"\n";
    const auto rays = fan({-2, 0.1, 0.2});
    for (const char* method : {"verlet", "gauss8", "dp54"}) {
        const Overrides overrides{std::string("integrator.method=") + method, "integrator.escape_radius=4",
                                  "integrator.step=0.05"};
        const auto a = traced(space, overrides, "packet", rays), b = traced(space, overrides, "scalar", rays);
        for (std::size_t i = 0; i < a.size(); ++i) {
            ASSERT_EQ(a[i].status, b[i].status) << method << ' ' << i << ' ' << static_cast<int>(a[i].failure);
            EXPECT_EQ(a[i].status, Status::escaped);
            expect_close(a[i].q, b[i].q, 1e-9);
            expect_close(a[i].p, b[i].p, 1e-9);
        }
    }
}

// The velocity ∂H/∂p at the start of a ray must have the given direction, and H must have the level H0.
TEST(FormulaSpace, StartsRaysInTheGivenDirection) {
    const char* const formulas[] = {"0.5*(px^2 + 2*py^2 + pz^2 + px*py)",
                                    "0.25*(px^4 + py^4 + pz^4) + 0.1*px*py",
                                    "sqrt(px^2 + py^2 + 3*pz^2)",
                                    "0.5*((px - y)^2 + (py + x)^2 + pz^2)",
                                    "exp(px^2 + py^2 + pz^2) - 1",
                                    "px^4 + py^4 + pz^4",
                                    "1e-8*(px^6 + py^6 + pz^6)",
                                    "2 - px^4 - 2*py^4 - pz^4",
                                    "(px - 1000)^4 + (py + 500)^4 + (pz - 3000)^4"};
    for (const std::string formula : formulas) {
        const auto plan = plan_of_text("[space]\nhamiltonian = \"formula\"\nH0 = 0.5\nH = \"" + formula + "\"\n" +
                                           view_text,
                                       {}, {}, false);
        const std::vector<RayInput> rays{{{0.3, 0.2, 0.1}, {1, 2, 3}},
                                         {{0.3, 0.2, 0.1}, {-2, 0.1, 0.4}},
                                         {{0, 0, 0}, {0.1, -1, 0.2}},
                                         {{0, 0, 0}, {0, 1, 1e-3}}};
        std::vector<RayEnd> ends;
        const auto starts = start_rays(*plan, rays);
        const auto points = trace_paths(*plan, starts, ends);
        for (const PathPoint& point : points) {
            if (point.step != 0) continue;
            const auto& d = rays[point.ray].direction;
            const double size = std::hypot(d[0], d[1], d[2]);
            for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(point.v[k], d[k] / size, 1e-10) << formula;
            EXPECT_NEAR(point.energy, 0.5, 1e-10) << formula;
        }
        for (const RayStart& start : starts) EXPECT_EQ(start.failure, Failure::none) << formula;
    }
    const auto none =
        plan_of_text("[space]\nhamiltonian = \"formula\"\nH0 = -1\nH = \"px^2 + py^2 + pz^2\"\n" + view_text,
                     {}, {}, false);
    EXPECT_EQ(start_rays(*none, {{{0, 0, 0}, {1, 0, 0}}})[0].failure, Failure::no_momentum);
    const auto singular =
        plan_of_text("[space]\nhamiltonian = \"formula\"\nH = \"(px^2 + py^2 + pz^2)/x - 1\"\n" + view_text,
                     {}, {}, false);
    EXPECT_EQ(start_rays(*singular, {{{0, 0, 0}, {1, 0, 0}}})[0].failure, Failure::singular_start);
}

TEST(FormulaSpace, AppliesDomainCaptureAndLengthScale) {
    const std::vector<RayInput> rays{{{0, 0, 0}, {1, 0, 0}}};
    const auto edge = traced(straight_space + "domain = \"2 - x\"\n", {}, "packet", rays)[0];
    EXPECT_EQ(edge.status, Status::escaped);
    EXPECT_NEAR(edge.q[0], 2, 1e-12);
    EXPECT_EQ(traced(straight_space + "capture = \"2 - x\"\n", {}, "packet", rays)[0].status, Status::captured);
    const auto unbounded = traced(straight_space, {"integrator.step=1"}, "packet", rays)[0],
               bounded = traced(straight_space + "length_scale = \"0.25\"\n", {"integrator.step=1"}, "packet", rays)[0];
    EXPECT_EQ(bounded.steps, 4 * unbounded.steps);
}

}  // namespace
}  // namespace kagero::test
