// Tests rays close to the horizon of holes that spin almost or exactly as fast as possible.
#include "tests/support/kerr_rays.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>
#include <boost/math/quadrature/tanh_sinh.hpp>
#include <nlohmann/json.hpp>

#include <cmath>
#include <iomanip>
#include <numbers>
#include <sstream>

namespace kagero::test {
namespace {

/// A camera 0.01 M above the horizon of a hole of spin 0.9999, in the plane of the equator.
constexpr const char* extreme_scene = R"([space]
hamiltonian = "kerr"
mass = 1
spin = 0.9999
[integrator]
escape_radius = 100
[camera]
position = [0, -1.431316317161638, 0]
look_at = [0, -3, 0]
up = [0, 0, 1]
fov = 100
observer = "zamo"
[film]
size = [160, 120]
)";
constexpr double extreme_spin = 0.9999;
constexpr Double3 extreme_position{0, -1.431316317161638, 0};

/// Returns the share of the directions from which light reaches an observer with zero angular momentum at radius r on
/// the equator, from the observer's metric coefficients (Bardeen, Press & Teukolsky 1972).
double visible_share(double a, double r) {
    const double delta = r * r - 2 * r + a * a, A = (r * r + a * a) * (r * r + a * a) - a * a * delta;
    const double lapse = r * std::sqrt(delta / A), omega = 2 * a * r / A, circumference = std::sqrt(A) / r;
    int visible = 0;
    const auto directions = even_directions(20000);
    for (const auto& [d_r, d_theta, d_phi] : directions) {
        // Light that comes from the direction d moves along −d. Its energy at infinity per energy at the observer:
        const double energy = lapse - omega * circumference * d_phi;
        if (!(energy > 0)) continue;
        const double l = circumference * d_phi / energy, p_theta = r * d_theta / energy;
        visible += KerrGeodesic(a, r, d_r > 0, l, p_theta * p_theta).escape_margin() > 0;
    }
    return double(visible) / double(directions.size());
}

std::vector<RayStart> starts_in_all_directions(const Plan& plan, ObserverKind observer, int count) {
    std::vector<RayInput> rays;
    for (const Double3& d : even_directions(count)) rays.push_back({extreme_position, d});
    return start_rays(plan, rays, observer);
}

double gradients_per_ray(const std::vector<RayEnd>& ends) {
    double sum = 0;
    for (const RayEnd& end : ends) sum += end.gradients;
    return sum / double(ends.size());
}

/// Expects that the rays escape which Carter's radial potential lets escape, and that all others are captured.
void expect_theoretical_statuses(const Plan& plan, const std::vector<RayStart>& starts,
                                 const std::vector<RayEnd>& ends) {
    std::size_t critical = 0;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        const KerrGeodesic ray = geodesic_of(plan, starts[i]);
        if (is_critical(ray)) ++critical;
        else EXPECT_EQ(ends[i].status, ray.escape_margin() > 0 ? Status::escaped : Status::captured) << "ray " << i;
    }
    EXPECT_LT(critical, ends.size() / 200);
}

class NearExtremeHorizon : public testing::TestWithParam<const char*> {};

TEST_P(NearExtremeHorizon, RaysOfAZamoEscapeWhereTheRadialPotentialAllowsIt) {
    constexpr int count = 2000;
    const auto plan = plan_for_rays(extreme_scene, "zamo", GetParam());
    const auto starts = starts_in_all_directions(*plan, ObserverKind::zamo, count);
    const auto ends = traced(*plan, starts);
    expect_theoretical_statuses(*plan, starts, ends);
    const auto escaped =
        std::count_if(ends.begin(), ends.end(), [](const RayEnd& end) { return end.status == Status::escaped; });
    const double a = extreme_spin, r = 1 + std::sqrt(1 - a * a) + 0.01;
    // The error of the share is about count^(−3/4), because the directions are even.
    EXPECT_NEAR(double(escaped) / count, visible_share(a, r), 3 * std::pow(count, -0.75));
    const auto picture = plan_of_text(extreme_scene, {}, with_strategy(GetParam()));
    std::vector<RayStart> pixels;
    for (std::uint32_t i = 0; i < 160 * 120; i += 7) pixels.push_back(pixel_ray_start(*picture, i % 160, i / 160));
    expect_theoretical_statuses(*picture, pixels, traced(*picture, pixels));
}

// Most rays of a zamo circle the hole several times, so that they take more steps than those of a falling observer.
TEST_P(NearExtremeHorizon, RaysOfAZamoTakeAtMostSixTimesTheGradientsOfAFallingObserver) {
    const auto gradients = [](ObserverKind observer, const char* name) {
        const auto plan = plan_for_rays(extreme_scene, name, GetParam());
        return gradients_per_ray(traced(*plan, starts_in_all_directions(*plan, observer, 2000)));
    };
    EXPECT_LT(gradients(ObserverKind::zamo, "zamo"), 6 * gradients(ObserverKind::falling, "falling"));
}
INSTANTIATE_TEST_SUITE_P(Strategies, NearExtremeHorizon, testing::Values("scalar", "packet"));

/// Fixture that runs the program in a temporary folder.
class ExtremePicture : public ProgramTest {
protected:
    /// Renders the scene with the given observer, and returns the report.
    nlohmann::json render(const std::string& observer) {
        write("extreme.toml", extreme_scene);
        const Outcome outcome = run("render extreme.toml -o picture.exr --quiet --json -D camera.observer=" + observer);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return nlohmann::json::parse(outcome.out);
    }
};

TEST_F(ExtremePicture, HasOnlyEscapedAndCapturedRays) {
    for (const char* observer : {"zamo", "falling"}) {
        const auto report = render(observer);
        EXPECT_EQ(int(report["status"]["escaped"]) + int(report["status"]["captured"]), 160 * 120) << report.dump(1);
        EXPECT_EQ(report["warnings"].size(), 0u) << report.dump(1);
    }
}

// Most of the light that a zamo sees has circled the hole several times. Captured rays take few steps.
TEST_F(ExtremePicture, TakesAtMostTwiceTheGradientsOfAFallingObserver) {
    const auto zamo = render("zamo"), falling = render("falling");
    EXPECT_LT(double(zamo["gradients"]), 2 * double(falling["gradients"]));
    EXPECT_LT(double(zamo["steps"]), 1.6 * double(falling["steps"]));
}

/// Returns the inward ray from (0, −y, 0) in the plane of the equator, around a hole of spin 1, with p_t = 1 and
/// x p_y − y p_x = −b.
RayStart prograde_ray(double b, double y) {
    const double r = std::sqrt(y * y - 1), f = 2 / r, px = -b / y;
    const double l[2] = {y / (r * r + 1), -r * y / (r * r + 1)};
    // 2H = p² − 1 − f (1 + l·p)² = A p_y² + 2 B p_y + C. The greater zero belongs to motion along +y.
    const double w = 1 + l[0] * px, A = 1 - f * l[1] * l[1], B = -f * w * l[1], C = px * px - 1 - f * w * w;
    const double py = (-B + std::sqrt(B * B - A * C)) / A;
    return {{0, -y, 0}, {px, py, 0}, 1, Failure::none, false, false};
}

/// Returns the angle from the start to the end, in outgoing coordinates, of the prograde ray with spin 1 that comes
/// from the radius r0, turns at r = b − 1, and leaves to the radius r1. With E = −1 and L = −b:
/// (dr/ds)² = r (r − c)(r² + c r − 2c) and dφ/ds = −c − (r² − c)/(r − 1)², where c = b − 1.
double swept_azimuth(double b, double r0, double r1) {
    const long double c = b - 1;
    boost::math::quadrature::tanh_sinh<long double> quadrature;
    const auto integral = [&](long double end) {  // over t with r = c + t²
        const auto integrand = [&](long double t) {
            const long double r = c + t * t;
            return 2 * (-c - (r * r - c) / ((r - 1) * (r - 1))) / std::sqrt(r * (r * r + c * r - 2 * c));
        };
        const long double middle = std::sqrt(c - 1);
        long double sum = quadrature.integrate(integrand, 0.0L, middle);
        for (long double t = middle, last = std::sqrt(end - c); t < last; t *= 4)
            sum += quadrature.integrate(integrand, t, std::min(4 * t, last));
        return sum;
    };
    // From the Boyer–Lindquist azimuth to the outgoing one: ∫_r^∞ dr/Δ = 1/(r − 1).
    return double(integral(r0) + integral(r1) + 1 / (r1 - 1.0L) - 1 / (r0 - 1.0L));
}

/// Returns the azimuth of the end of such a ray on the sphere with the radius `escape`. It starts at (0, −start, 0).
/// x + iy = (r − i) exp(iφ).
double azimuth_of_end(double b, double start, double escape) {
    const double r0 = std::sqrt(start * start - 1), r1 = std::sqrt(escape * escape - 1);
    return -std::numbers::pi / 2 + std::atan2(1, r0) + swept_azimuth(b, r0, r1) - std::atan2(1, r1);
}

class MaximalSpin : public testing::TestWithParam<const char*> {};

// Prograde light with 2 < b < 2.028 turns close to the horizon r = 1. It circles the hole by 3.5/(b − 2) radians.
TEST_P(MaximalSpin, ProgradeLightNearTheCriticalImpactParameterTurns) {
    constexpr double start = 50, escape = 60;
    std::string scene = scene_with_hole(1);
    scene.replace(scene.find("escape_radius = 40"), 18, "escape_radius = 60\nmax_steps = 100000");
    const auto plan = plan_for_rays(scene, "", GetParam());
    for (int i = 0; i < 20; ++i) {
        const double b = 2 + 0.028 * (i + 0.5) / 20;
        const RayStart ray = prograde_ray(b, start);
        const RayEnd end = traced(*plan, {ray})[0];
        EXPECT_EQ(end.status, Status::escaped) << b;
        if (end.status != Status::escaped) continue;
        const auto reference = reference_end(geodesic_of(*plan, ray), beyond_sphere(escape));
        ASSERT_TRUE(reference) << b;
        const double azimuth = azimuth_of_end(b, start, escape);
        const double error = std::hypot(end.q[0] / escape - std::cos(azimuth), end.q[1] / escape - std::sin(azimuth));
        EXPECT_LT(error, default_tolerance * reference->conditioning) << b;
    }
    for (const double b : {0.0, 1.0, 1.9, 1.99, 1.999, 1.9999})
        EXPECT_EQ(traced(*plan, {prograde_ray(b, start)})[0].status, Status::captured) << b;
}

// Closer to the critical impact parameter, such light circles the hole thousands of times, which takes more than
// max_steps steps with step control. It is then traced with steps in an angle. An error δb of the impact parameter
// changes the direction by 3.5 δb/(b − 2)².
TEST_P(MaximalSpin, LightThatCirclesTheHoleThousandsOfTimesIsFollowedToItsEnd) {
    constexpr double start = 50, escape = 60, backward_error = 5e-11;
    std::string scene = scene_with_hole(1);
    scene.replace(scene.find("escape_radius = 40"), 18, "escape_radius = 60");
    const auto plan = plan_for_rays(scene, "", GetParam());
    for (const double b : {2.0014, 2.0005, 2.0001, 2.00003, 2.0000001}) {
        const RayEnd end = traced(*plan, {prograde_ray(b, start)})[0];
        EXPECT_EQ(end.status, Status::escaped) << b;
        EXPECT_GT(end.steps, plan->run.max_steps);
        const double azimuth = azimuth_of_end(b, start, escape);
        const double error = std::hypot(end.q[0] / escape - std::cos(azimuth), end.q[1] / escape - std::sin(azimuth));
        EXPECT_LT(error, backward_error * 3.5 / ((b - 2) * (b - 2))) << b;
    }
    const std::vector<RayEnd> ends =
        traced(*plan, {prograde_ray(2.0014, start), prograde_ray(3, start), prograde_ray(1.9999, start)});
    EXPECT_EQ(ends[0].status, Status::escaped);
    EXPECT_EQ(ends[1].status, Status::escaped);
    EXPECT_EQ(ends[2].status, Status::captured);
}

std::string exact_text(double number) {
    std::ostringstream text;
    text << std::setprecision(17) << number;
    return text.str();
}

// With a stated method, no other method is used. The warning then names a method that follows such light with few
// steps.
TEST_F(ExtremePicture, WarnsOfRaysThatCircleTheHoleAndNamesAMethodForThem) {
    write("maximal.toml", scene_with_hole(1));
    const std::vector<double> impact_parameters{2.00001, 2.0005, 2.0014};
    std::string rays = "x,y,z,dx,dy,dz\n";
    for (const double b : impact_parameters) {
        constexpr double y = 30, r2 = y * y - 1;
        const RayStart start = prograde_ray(b, y);
        // dq/dλ = p − f (1 + l·p) l
        const double r = std::sqrt(r2), f = 2 / r, l[2] = {y / (r2 + 1), -r * y / (r2 + 1)},
                     w = 1 + l[0] * start.p[0] + l[1] * start.p[1];
        rays +=
            "0,-30,0," + exact_text(start.p[0] - f * w * l[0]) + ',' + exact_text(start.p[1] - f * w * l[1]) + ",0\n";
    }
    write("rays.csv", rays);
    const Outcome with_step_control =
        run("trace maximal.toml --rays rays.csv -D integrator.method=dp85 -D integrator.tolerance=1e-10");
    EXPECT_NE(with_step_control.out.find("step_limit"), std::string::npos);
    const std::string advice = "integrator.method = \"mino-srkn11\"";
    EXPECT_NE(with_step_control.err.find(advice), std::string::npos) << with_step_control.err;
    for (const char* method : {"", " -D integrator.method=mino-srkn11"}) {
        const auto rows = lines_of(run(std::string("trace maximal.toml --rays rays.csv") + method).out);
        for (std::size_t i = 0; i < impact_parameters.size(); ++i)
            EXPECT_NE(rows.at(i + 1).find(",escaped,"), std::string::npos) << rows[i + 1];
    }
}
INSTANTIATE_TEST_SUITE_P(Strategies, MaximalSpin, testing::Values("scalar", "packet"));

}  // namespace
}  // namespace kagero::test
