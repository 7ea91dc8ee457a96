// Layers that say how wrong a picture's rays are, against closed forms: the orbits around a Schwarzschild hole, the circles of a
// fisheye.
#include "plan_fixture.h"
#include "schwarzschild_orbit.h"

#include "render/camera.h"
#include "render/ray_errors.h"
#include "scene/vector3.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace kagero::test {
namespace {

constexpr const char* hole_scene = R"([space]
hamiltonian = "schwarzschild"
rg = 1
[integrator]
escape_radius = 20
[camera]
position = [0, -10, 0]
look_at = [0, 0, 0]
up = [0, 0, 1]
[film]
size = [48, 48]
layers = ["position_error", "rounding_error"]
)";

// From the eye all rays go in circles through the opposite point (1, 0, 0); before it stands a screen.
constexpr const char* fisheye_scene = R"([space]
hamiltonian = "fisheye"
n0 = 2
radius = 1
[integrator]
escape_radius = 10
[camera]
position = [-1, 0, 0]
look_at = [0, 0, 0]
up = [0, 0, 1]
[film]
size = [48, 48]
layers = ["position_error", "rounding_error"]
[[object]]
name = "screen"
shape = "rectangle"
origin = [0.5, -5, -5]
edge_u = [0, 10, 0]
edge_v = [0, 0, 10]
)";

Double3 of(const double (&x)[3]) {
    return {x[0], x[1], x[2]};
}

/// Where the ray of a RayStart should end; a status of `failed` where the closed form says nothing.
using Exact = std::function<RayEnd(const RayStart&, const RayEnd&)>;

RayEnd exact_escape(const RayStart& ray, const RayEnd& end) {
    RayEnd exact = end;
    const Double3 q = of(ray.q), p = of(ray.p);
    const double b = length(cross(q, p)) / ray.pt;
    exact.status = Status::failed;
    if (end.status != Status::escaped || !(b > critical_impact * (1 + 1e-4))) return exact;
    exact.status = Status::escaped;
    const Orbit orbit(b);
    const double r0 = length(q), angle = orbit.swept_around(r0) + orbit.phase(1 / r0) - orbit.phase(1 / 20.0);
    const Velocity v = orbit.velocity_after(r0, angle);
    const Double3 outward = unit(q), across = unit(subtract(p, scaled(outward, dot(p, outward))));
    const double size = std::hypot(v.along, v.aside), c = std::cos(angle), s = std::sin(angle);
    for (std::size_t k = 0; k < 3; ++k)
        exact.v[k] = (v.along * (c * outward[k] + s * across[k]) + v.aside * (c * across[k] - s * outward[k])) / size;
    return exact;
}

/// The circle through (−1, 0, 0) along d has its centre at c = −d_x/d_u from the middle, d_u the part of d across x.
RayEnd exact_hit(const RayStart& ray, const RayEnd& end) {
    RayEnd exact = end;
    const long double y = ray.p[1], z = ray.p[2], across = std::hypot(y, z), c = ray.p[0] / across;
    const long double u = 0.75L / (c + std::sqrt(c * c + 0.75L));
    exact.q[0] = 0.5, exact.q[1] = double(u * y / across), exact.q[2] = double(u * z / across);
    return exact;
}

/// What a layer says beside what is true, of the pixels where both mean something.
struct Pair {
    double estimate, truth;
};

struct Compared {
    std::vector<Pair> pairs;
    std::size_t unknown = 0;

    /// Share of the pixels whose estimate is the truth within a factor.
    double share_within(double factor) const {
        std::size_t within = 0;
        for (const Pair& pair : pairs) within += pair.estimate <= factor * pair.truth && pair.truth <= factor * pair.estimate;
        return double(within) / double(pairs.size());
    }
};

/// Pixels of which the truth is less than `clear` roundings of the end itself are left out: there luck rules, and the closed form
/// has roundings of its own.
Compared compare(const char* scene, const std::string& method, double step, const Exact& exact, const std::string& layer,
                 const std::string& precision, double clear) {
    Options options;
    options.precision = precision;
    const char* key = method == "dp54" || method == "rkf78" ? "tolerance" : "step";
    const auto plan = plan_of_text(
        scene, {"integrator.method=\"" + method + "\"", std::string("integrator.") + key + "=" + std::to_string(step)}, options);
    Film film(48, 48, {"position_error", "rounding_error"});
    render(*plan, film);
    std::vector<RayStart> starts;
    for (std::uint32_t y = 0; y < 48; ++y)
        for (std::uint32_t x = 0; x < 48; ++x) starts.push_back(pixel_ray(*plan, x, y));
    std::vector<RayEnd> ends;
    trace(*plan, starts, ends);
    Compared compared;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        const RayEnd should = exact(starts[i], ends[i]);
        const double estimate = film.plane(layer)[i];
        if (should.status == Status::failed) continue;
        if (std::isnan(estimate)) {
            ++compared.unknown;
            continue;
        }
        const double truth = pixels_apart(*plan, should, ends[i]);
        if (truth >= clear * (precision == "float" ? 0x1p-24 : 0x1p-53) / pixel_size(plan->scene, 1))
            compared.pairs.push_back({estimate, truth});
    }
    return compared;
}

struct Way {
    const char* method;
    double step;
};

void expect_estimates(const char* scene, const Way& way, const Exact& exact, const std::string& precision, double share = 0.95) {
    SCOPED_TRACE(way.method);
    const Compared compared =
        compare(scene, way.method, way.step, exact, "position_error", precision, precision == "float" ? 0.2 : 1000);
    ASSERT_GT(compared.pairs.size(), 1000u);
    EXPECT_LT(compared.unknown, 50u);
    EXPECT_GE(compared.share_within(3), share);
    ::testing::Test::RecordProperty(std::string("within_2_") + way.method + "_" + precision,
                                    std::to_string(compared.share_within(2)));
}

TEST(PositionError, IsTheTrueErrorAroundAHole) {
    for (const Way& way :
         {Way{"verlet", 0.05}, {"suzuki4-nine", 0.1}, {"rk4", 0.05}, {"gauss4", 0.1}, {"gauss8", 0.3}, {"dp54", 1e-6}})
        expect_estimates(hole_scene, way, exact_escape, "double");
    // Where the longest step governs, and not the tolerance.
    expect_estimates(hole_scene, {"dp54", 0.1}, exact_escape, "double", 0.75);
    expect_estimates(hole_scene, {"gauss8", 0.1}, exact_escape, "float");
}

TEST(PositionError, IsTheTrueErrorInAFisheye) {
    for (const Way& way : {Way{"verlet", 0.02}, {"srkn6", 0.1}, {"rk4", 0.05}, {"gauss4", 0.1}, {"gauss8", 0.3}, {"dp54", 1e-6}})
        expect_estimates(fisheye_scene, way, exact_hit, "double");
    expect_estimates(fisheye_scene, {"rk4", 0.02}, exact_hit, "float");
}

/// Ends of the picture's rays with other roundings: by steps longer by one part in 10^12 or so, which changes the method's error as
/// little (Vignes, Math. Comput. Simul. 35, 1993, perturbs single roundings to the same end).
std::vector<RayEnd> ends_of(Plan& plan, double longer) {
    const double step = plan.job.step, tolerance = plan.job.tolerance;
    plan.job.step *= longer, plan.job.tolerance *= longer;
    std::vector<RayStart> starts;
    for (std::uint32_t y = 0; y < plan.scene.film.height; ++y)
        for (std::uint32_t x = 0; x < plan.scene.film.width; ++x) starts.push_back(pixel_ray(plan, x, y));
    std::vector<RayEnd> ends;
    trace(plan, starts, ends);
    for (RayEnd& end : ends) end = in_space(plan, end);
    plan.job.step = step, plan.job.tolerance = tolerance;
    return ends;
}

/// A bound on the rounding errors of a picture's rays, over the spread of those of other runs.
struct Tightness {
    double holding = 0;  ///< share of the rays whose spread is less
    double median = 0;   ///< bound over spread
    std::size_t compared = 0, unknown = 0;
};
Tightness tightness(Plan& plan) {
    Film film(plan.scene.film.width, plan.scene.film.height, {"rounding_error"});
    render(plan, film);
    constexpr int runs = 3;
    const double slightly = plan.kernel->precision == Precision::float32 ? 0x1p-20 : 0x1p-40;
    const std::vector<RayEnd> ends = ends_of(plan, 1);
    std::vector<double> squares(ends.size());
    for (int run = 1; run <= runs; ++run) {
        const std::vector<RayEnd> others = ends_of(plan, 1 + run * slightly);
        for (std::size_t i = 0; i < ends.size(); ++i) squares[i] += std::pow(pixel_error(plan, others[i], ends[i]), 2) / runs;
    }
    Tightness result;
    std::vector<double> ratios;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        const double bound = film.plane("rounding_error")[i], spread = std::sqrt(0.5 * squares[i]);  // both ends are rounded
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
        options.precision = c.precision;
        const auto plan = plan_of_text(c.scene, {std::string("integrator=") + c.integrator}, options);
        const Tightness t = tightness(*plan);
        ASSERT_GT(t.compared, 1000u);
        EXPECT_LT(t.unknown, 50u);
        EXPECT_GE(t.holding, 0.99);
        EXPECT_GT(t.median, 2);
        EXPECT_LT(t.median, 120);
    }
}

// What the scene's formula is compiled to has about the operations of the same Hamiltonian in C++.
TEST(RoundingError, OfAFormulaIsThatOfItsSpace) {
    const std::string formula = R"toml({hamiltonian="formula", H="0.5*(px^2+py^2+pz^2-(2/(1+x^2+y^2+z^2))^2)"})toml";
    const Overrides overrides{"integrator.method=\"gauss8\"", "integrator.step=0.1"};
    Overrides as_formula = overrides;
    as_formula.insert(as_formula.begin(), "space=" + formula);
    Film film(48, 48, {"rounding_error"}), same(48, 48, {"rounding_error"});
    render(*plan_of_text(fisheye_scene, overrides), film);
    render(*plan_of_text(fisheye_scene, as_formula), same);
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

// Nothing is known of a ray that ends elsewhere when it is traced otherwise; of one that is captured there is nothing to know.
TEST(PositionError, IsNotANumberWhereThereIsNone) {
    const auto plan = plan_of_text(hole_scene, {"integrator.method=\"gauss8\"", "integrator.max_steps=20"});
    Film film(48, 48, {"status", "position_error"});
    render(*plan, film);
    std::size_t captured = 0, limited = 0;
    for (std::size_t i = 0; i < 48 * 48; ++i) {
        const auto status = static_cast<Status>(static_cast<int>(film.plane("status")[i]));
        const float error = film.plane("position_error")[i];
        EXPECT_TRUE(std::isnan(error) || error >= 0);
        if (status == Status::step_limit) {
            EXPECT_TRUE(std::isnan(error));
            ++limited;
        }
        if (status != Status::captured || std::isnan(error)) continue;
        EXPECT_EQ(error, 0);
        ++captured;
    }
    EXPECT_GT(captured, 10u);
    EXPECT_GT(limited, 10u);
}

// What a ray needs does not depend on the strategy; a packet of one ray is always full.
TEST(IterationsAndOccupancy, BelongToRaysAndToPackets) {
    Film packets(48, 48, {"occupancy", "newton", "steps"}), single(48, 48, {"occupancy", "newton"});
    RunReport report;
    double least = 1;
    for (const char* method : {"gauss8", "verlet"}) {
        const Overrides how{std::string("integrator.method=") + method, "integrator.step=0.8"};
        const auto in_packets = plan_of_text(hole_scene, how), alone = plan_of_text(hole_scene, how, with_strategy("scalar"));
        report = render(*in_packets, packets);
        render(*alone, single);
        least = 1;
        for (std::size_t i = 0; i < 48 * 48; ++i) {
            EXPECT_EQ(packets.plane("newton")[i], single.plane("newton")[i]) << method;
            EXPECT_GE(packets.plane("newton")[i], packets.plane("steps")[i]) << method;
            EXPECT_EQ(single.plane("occupancy")[i], 1);
            EXPECT_LE(packets.plane("occupancy")[i], 1);
            least = std::min(least, double(packets.plane("occupancy")[i]));
        }
    }
    const double mean = double(report.counters.active_lane_steps) / double(report.counters.issued_lane_steps);
    EXPECT_GT(least, 0);
    EXPECT_LE(least, mean);
    const auto explicit_method = plan_of_text(hole_scene, {"integrator.method=\"rk4\""});
    render(*explicit_method, packets);
    for (std::size_t i = 0; i < 48 * 48; ++i) EXPECT_EQ(packets.plane("newton")[i], 0);
}

}  // namespace
}  // namespace kagero::test
