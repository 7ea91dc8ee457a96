// The layer that bounds what rounding did to a picture's rays.
#include "tests/support/end_errors.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace kagero::test {
namespace {

constexpr const char* straight_scene = R"([space]
hamiltonian = "flat"
[integrator]
escape_radius = 20
[camera]
position = [0.3, -10, 0.2]
look_at = [0, 0, 0]
up = [0, 0, 1]
[film]
size = [48, 48]
layers = ["position_error", "rounding_error"]
[[object]]
name = "ball"
shape = "sphere"
center = [0, 0, 0]
radius = 3
)";

/// A line, onto the ball or past it.
RayEnd exact_line(const RayStart& ray, const RayEnd& end) {
    RayEnd exact = end;
    const long double size = std::hypot(static_cast<long double>(ray.p[0]), ray.p[1], ray.p[2]);
    long double d[3], along = 0, square = 0;
    for (std::size_t k = 0; k < 3; ++k)
        d[k] = ray.p[k] / size, along += d[k] * ray.q[k], square += static_cast<long double>(ray.q[k]) * ray.q[k];
    const long double radius = end.status == Status::hit ? 3 : 20,
                      root = std::sqrt(along * along - square + radius * radius);
    const long double t = -along + (end.status == Status::hit ? -root : root);
    for (std::size_t k = 0; k < 3; ++k) exact.q[k] = double(ray.q[k] + t * d[k]), exact.v[k] = double(d[k]);
    return exact;
}

/// Ends of the picture's rays with other roundings: by steps longer by one part in 10^12 or so, which changes the
/// method's error as little (Vignes, Math. Comput. Simul. 35, 1993, perturbs single roundings to the same end).
std::vector<RayEnd> ends_of(Plan& plan, double longer) {
    const double step = plan.run.step, tolerance = plan.run.tolerance;
    plan.run.step *= longer, plan.run.tolerance *= longer;
    std::vector<RayStart> starts;
    for (std::uint32_t y = 0; y < plan.description().film.height; ++y)
        for (std::uint32_t x = 0; x < plan.description().film.width; ++x) starts.push_back(pixel_ray(plan, x, y));
    std::vector<RayEnd> ends;
    trace(plan, starts, ends);
    for (RayEnd& end : ends) end = in_space(plan, end);
    plan.run.step = step, plan.run.tolerance = tolerance;
    return ends;
}

/// A bound on the rounding errors of a picture's rays, over the spread of those of other runs.
struct Tightness {
    double holding = 0;  ///< share of the rays whose spread is less
    double median = 0;   ///< bound over spread
    std::size_t compared = 0, unknown = 0;
};
Tightness tightness(Plan& plan) {
    Film film(plan.description().film.width, plan.description().film.height, {"rounding_error"});
    render_with_errors(plan, film);
    constexpr int runs = 3;
    const double slightly = plan.run.kernel->precision == Precision::float32 ? 0x1p-20 : 0x1p-40;
    const std::vector<RayEnd> ends = ends_of(plan, 1);
    std::vector<double> squares(ends.size());
    for (int run = 1; run <= runs; ++run) {
        const std::vector<RayEnd> others = ends_of(plan, 1 + run * slightly);
        for (std::size_t i = 0; i < ends.size(); ++i)
            squares[i] += std::pow(pixel_error(plan, others[i], ends[i]), 2) / runs;
    }
    Tightness result;
    std::vector<double> ratios;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        const double bound = film.plane("rounding_error")[i],
                     spread = std::sqrt(0.5 * squares[i]);  // both ends are rounded
        if (!has_end(ends[i]) || std::isnan(spread)) continue;
        if (std::isnan(bound)) {
            ++result.unknown;
            continue;
        }
        result.holding += bound >= spread;
        ratios.push_back(bound / spread);
    }
    result.compared = ratios.size();
    result.holding /= double(ratios.size());
    std::nth_element(ratios.begin(), ratios.begin() + std::ptrdiff_t(ratios.size() / 2), ratios.end());
    result.median = ratios[ratios.size() / 2];
    return result;
}

struct Case {
    const char* scene;
    const char* integrator;  ///< of the scene, in TOML
    const char* precision = "double";
};

// If N roundings worked together they would do √N times what they do.
TEST(RoundingError, BoundsTheSpreadOfErrors) {
    for (const Case& c : {Case{hole_scene, "{method=\"gauss8\", step=0.3, escape_radius=20}"},
                          {hole_scene, "{method=\"verlet\", step=0.05, escape_radius=20}"},
                          {hole_scene, "{method=\"suzuki4-nine\", step=0.1, escape_radius=20}"},
                          {hole_scene, "{method=\"rk4\", step=0.05, escape_radius=20}"},
                          {hole_scene, "{method=\"dp54\", tolerance=1e-6, escape_radius=20}"},
                          {hole_scene, "{method=\"ks-s10\", step=0.3, escape_radius=20}"},
                          {hole_scene, "{method=\"orbit-srkn6\", step=0.05, escape_radius=20}"},
                          {hole_scene, "{method=\"gauss8\", step=0.1, escape_radius=20}", "float"},
                          {fisheye_scene, "{method=\"srkn6\", step=0.1, escape_radius=10}"},
                          {fisheye_scene, "{method=\"verlet\", step=0.02, escape_radius=10}"},
                          {fisheye_scene, "{method=\"rkf78\", tolerance=1e-8, escape_radius=10}"},
                          {fisheye_scene, "{method=\"gauss16\", step=0.05, escape_radius=10}"},
                          {fisheye_scene, "{method=\"rk4\", step=0.02, escape_radius=10}", "float"}}) {
        SCOPED_TRACE(std::string(c.integrator) + " " + c.precision);
        Options options;
        options.precision = precision_named(c.precision);
        const auto plan = plan_of_text(c.scene, {std::string("integrator=") + c.integrator}, options);
        const Tightness t = tightness(*plan);
        ASSERT_GT(t.compared, 1000u);
        EXPECT_LT(t.unknown, 50u);
        EXPECT_GE(t.holding, 0.99);
        EXPECT_GT(t.median, 2);
        EXPECT_LT(t.median, 200);
    }
}

// What the scene's formula is compiled to has about the operations of the same Hamiltonian in C++.
TEST(RoundingError, OfAFormulaIsThatOfItsSpace) {
    const std::string formula = R"toml({hamiltonian="formula", H="0.5*(px^2+py^2+pz^2-(2/(1+x^2+y^2+z^2))^2)"})toml";
    const Overrides overrides{"integrator.method=\"gauss8\"", "integrator.step=0.1"};
    Overrides as_formula = overrides;
    as_formula.insert(as_formula.begin(), "space=" + formula);
    Film film(48, 48, {"rounding_error"}), same(48, 48, {"rounding_error"});
    render_with_errors(*plan_of_text(fisheye_scene, overrides), film);
    render_with_errors(*plan_of_text(fisheye_scene, as_formula), same);
    for (std::size_t i = 0; i < 48 * 48; ++i) {
        ASSERT_GT(same.plane("rounding_error")[i], 0.5f * film.plane("rounding_error")[i]);
        ASSERT_LT(same.plane("rounding_error")[i], 2 * film.plane("rounding_error")[i]);
    }
}

// Steps so fine, or numbers so coarse, that rounding is all there is to the true error.
TEST(RoundingError, BoundsTheTrueError) {
    struct Exactly {
        const char* scene;
        const char* method;
        Exact exact;
        const char* precision;
    };
    for (const Exactly& c : {Exactly{hole_scene, "gauss12", exact_escape, "float"},
                             Exactly{fisheye_scene, "gauss12", exact_hit, "float"},
                             Exactly{fisheye_scene, "gauss16", exact_hit, "double"}}) {
        const Compared compared = compare(c.scene, c.method, 0.05, c.exact, "rounding_error", c.precision, 0);
        ASSERT_GT(compared.pairs.size(), 1000u);
        const auto holding = std::count_if(compared.pairs.begin(), compared.pairs.end(),
                                           [](const Pair& pair) { return pair.truth <= pair.estimate; });
        EXPECT_GE(double(holding), 0.99 * double(compared.pairs.size()));
    }
}

TEST(RoundingError, BoundsTheTrueErrorOfStraightRays) {
    for (const char* camera : {"perspective", "orthographic"}) {
        const Compared compared = compare(straight_scene, "gauss8", 0.05, exact_line, "rounding_error", "float", 0,
                                          {std::string("camera.type=") + camera});
        ASSERT_GT(compared.pairs.size(), 2000u);
        std::size_t holding = 0;
        std::vector<double> ratios;
        for (const Pair& pair : compared.pairs) {
            holding += pair.truth <= pair.estimate;
            if (pair.truth > 0) ratios.push_back(pair.estimate / pair.truth);
        }
        std::sort(ratios.begin(), ratios.end());
        EXPECT_LT(ratios[ratios.size() / 2], 30) << camera;
        EXPECT_GE(double(holding), 0.99 * double(compared.pairs.size()));
    }
}

}  // namespace
}  // namespace kagero::test
