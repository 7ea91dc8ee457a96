// Tests of the error layer `rounding_error`, which bounds the effect of rounding on the ray ends of a picture.
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

/// Returns the exact end of a straight ray: on the ball of radius 3 if `end` is a hit, otherwise on the escape sphere
/// of radius 20.
RayEnd exact_line(const RayStart& ray, const RayEnd& end) {
    RayEnd exact = end;
    const long double size = std::hypot(static_cast<long double>(ray.p[0]), ray.p[1], ray.p[2]);
    long double d[3], along = 0, distance_squared = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        d[k] = ray.p[k] / size;
        along += d[k] * ray.q[k];
        distance_squared += static_cast<long double>(ray.q[k]) * ray.q[k];
    }
    const long double radius = end.status == Status::hit ? 3 : 20,
                      half_chord = std::sqrt(along * along - distance_squared + radius * radius);
    const long double t = -along + (end.status == Status::hit ? -half_chord : half_chord);
    for (std::size_t k = 0; k < 3; ++k) {
        exact.q[k] = double(ray.q[k] + t * d[k]);
        exact.v[k] = double(d[k]);
    }
    return exact;
}

/// Returns the ends of all camera rays, computed with steps and tolerance multiplied by `factor`. A factor such as 1 +
/// 1e-12 changes the error of the method by a similarly small fraction, but all roundings differ. For the same purpose,
/// Vignes (Math. Comput. Simul. 35, 1993) perturbs each rounding.
std::vector<RayEnd> ends_of(Plan& plan, double factor) {
    const double step = plan.run.step, tolerance = plan.run.tolerance;
    plan.run.step *= factor;
    plan.run.tolerance *= factor;
    std::vector<RayStart> starts;
    for (std::uint32_t y = 0; y < plan.description().film.height; ++y)
        for (std::uint32_t x = 0; x < plan.description().film.width; ++x) starts.push_back(pixel_ray_start(plan, x, y));
    std::vector<RayEnd> ends;
    trace(plan, starts, ends);
    for (RayEnd& end : ends) end = to_hamiltonian_coordinates(plan, end);
    plan.run.step = step;
    plan.run.tolerance = tolerance;
    return ends;
}

/// Comparison of the rounding bounds of a picture's rays with the spread of their ends over runs with other roundings.
struct Tightness {
    double valid_share = 0;   ///< Share of the rays whose bound is at least the spread.
    double median_ratio = 0;  ///< Median of bound / spread.
    std::size_t compared = 0;       ///< Number of rays with a bound.
    std::size_t without_bound = 0;  ///< Number of rays whose bound is NaN.
};

/// Renders the plan's picture and traces its rays again in 3 perturbed runs. The spread of a ray is the root mean
/// square of the pixel errors between the unperturbed and the perturbed ends, divided by √2.
Tightness tightness(Plan& plan) {
    Film film(plan.description().film.width, plan.description().film.height, {"rounding_error"});
    render_with_errors(plan, film);
    constexpr int runs = 3;
    const double perturbation = plan.run.kernel->precision == Precision::float32 ? 0x1p-20 : 0x1p-40;
    const std::vector<RayEnd> ends = ends_of(plan, 1);
    std::vector<double> squares(ends.size());
    for (int run = 1; run <= runs; ++run) {
        const std::vector<RayEnd> others = ends_of(plan, 1 + run * perturbation);
        for (std::size_t i = 0; i < ends.size(); ++i)
            squares[i] += std::pow(pixel_error(plan, others[i], ends[i]), 2) / runs;
    }
    Tightness result;
    std::vector<double> ratios;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        const double bound = film.plane("rounding_error")[i],
                     spread = std::sqrt(0.5 * squares[i]);  // factor 0.5: both ends have rounding errors
        if (!has_visible_end(ends[i]) || std::isnan(spread)) continue;
        if (std::isnan(bound)) {
            ++result.without_bound;
            continue;
        }
        result.valid_share += bound >= spread;
        ratios.push_back(bound / spread);
    }
    result.compared = ratios.size();
    result.valid_share /= double(ratios.size());
    std::nth_element(ratios.begin(), ratios.begin() + std::ptrdiff_t(ratios.size() / 2), ratios.end());
    result.median_ratio = ratios[ratios.size() / 2];
    return result;
}

struct Case {
    const char* scene;
    const char* integrator;  ///< Value of the scene's key `integrator`, in TOML.
    const char* precision = "double";
};

// The bound is the sum of the absolute effects of N roundings. Independent roundings partly cancel, so that the spread
// is smaller by a factor of about √N. The median of bound / spread is therefore expected to lie between 2 and 200.
TEST(RoundingError, BoundsTheSpreadOverRunsWithOtherRoundings) {
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
        EXPECT_LT(t.without_bound, 50u);
        EXPECT_GE(t.valid_share, 0.99);
        EXPECT_GT(t.median_ratio, 2);
        EXPECT_LT(t.median_ratio, 200);
    }
}

// The formula is the Hamiltonian of the fisheye. Its compiled program has nearly the same operations as the C++ version
// of the fisheye, so that the two bounds differ by less than a factor of 2.
TEST(RoundingError, IsSimilarForAFormulaAndTheBuiltInSpace) {
    const std::string formula = R"toml({hamiltonian="formula", H="0.5*(px^2+py^2+pz^2-(2/(1+x^2+y^2+z^2))^2)"})toml";
    const Overrides overrides{"integrator.method=\"gauss8\"", "integrator.step=0.1"};
    Overrides as_formula = overrides;
    as_formula.insert(as_formula.begin(), "space=" + formula);
    Film film(48, 48, {"rounding_error"}), formula_film(48, 48, {"rounding_error"});
    render_with_errors(*plan_of_text(fisheye_scene, overrides), film);
    render_with_errors(*plan_of_text(fisheye_scene, as_formula), formula_film);
    for (std::size_t i = 0; i < 48 * 48; ++i) {
        ASSERT_GT(formula_film.plane("rounding_error")[i], 0.5f * film.plane("rounding_error")[i]);
        ASSERT_LT(formula_film.plane("rounding_error")[i], 2 * film.plane("rounding_error")[i]);
    }
}

// The steps are so short, or the precision is so low, that the true error consists of rounding only. The true error is
// the distance from the closed form. The bound must be at least the true error for 99 % of the rays.
TEST(RoundingError, BoundsTheTrueErrorIfRoundingDominates) {
    struct CaseWithClosedForm {
        const char* scene;
        const char* method;
        ExactEnd exact;
        const char* precision;
    };
    for (const CaseWithClosedForm& c : {CaseWithClosedForm{hole_scene, "gauss12", exact_escape, "float"},
                                        CaseWithClosedForm{fisheye_scene, "gauss12", exact_hit, "float"},
                                        CaseWithClosedForm{fisheye_scene, "gauss16", exact_hit, "double"}}) {
        const Comparison compared = compare(c.scene, c.method, 0.05, c.exact, "rounding_error", c.precision, 0);
        ASSERT_GT(compared.pairs.size(), 1000u);
        const auto is_valid = [](const ErrorPair& pair) { return pair.truth <= pair.estimate; };
        const auto valid_bounds = std::count_if(compared.pairs.begin(), compared.pairs.end(), is_valid);
        EXPECT_GE(double(valid_bounds), 0.99 * double(compared.pairs.size()));
    }
}

// Straight rays have no method error, so that the true error consists of rounding only. The bound must hold for 99 % of
// the rays, and its median must be at most 30 times the true error.
TEST(RoundingError, BoundsTheTrueErrorOfStraightRays) {
    for (const char* camera : {"perspective", "orthographic"}) {
        const Comparison compared = compare(straight_scene, "gauss8", 0.05, exact_line, "rounding_error", "float", 0,
                                          {std::string("camera.type=") + camera});
        ASSERT_GT(compared.pairs.size(), 2000u);
        std::size_t valid_bounds = 0;
        std::vector<double> ratios;
        for (const ErrorPair& pair : compared.pairs) {
            valid_bounds += pair.truth <= pair.estimate;
            if (pair.truth > 0) ratios.push_back(pair.estimate / pair.truth);
        }
        std::sort(ratios.begin(), ratios.end());
        EXPECT_LT(ratios[ratios.size() / 2], 30) << camera;
        EXPECT_GE(double(valid_bounds), 0.99 * double(compared.pairs.size()));
    }
}

}  // namespace
}  // namespace kagero::test
