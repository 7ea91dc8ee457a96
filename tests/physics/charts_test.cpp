// Compares rays near Kerr holes, which change between ingoing and outgoing coordinates on their way, with an
// independent integration in Boyer–Lindquist coordinates. The bound on the difference is the tolerance of the steps
// times the conditioning of the ray.
#include "tests/support/kerr_rays.h"

#include "rays/camera.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kagero::test {
namespace {

constexpr const char* strategies[] = {"scalar", "packet"};

/// Compares the rays of an observer with the reference, for scalar and packet kernels. `beyond` is the surface on which
/// the rays end, with `status`. Returns the number of ends that were compared.
int compare_with_reference(const std::string& scene, const std::string& observer, const std::vector<RayInput>& rays,
                           const Beyond& beyond, Status status, double tolerance = default_tolerance) {
    const auto first_plan = plan_for_rays(scene, observer);
    const auto starts = start_rays(*first_plan, rays, observer_of(observer));
    std::vector<std::optional<ReferenceEnd>> expected(rays.size());
    std::vector<bool> is_compared(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (starts[i].failure != Failure::none) continue;
        const KerrGeodesic ray = geodesic_of(*first_plan, starts[i]);
        // H = 0 at the start. The cancellation in dr/ds is the greater, the more energy the observer sees in the ray.
        EXPECT_NEAR(double(ray.potential(ray.start[0]) / (ray.start[1] * ray.start[1])), 1, 1e-6) << "ray " << i;
        is_compared[i] = !is_critical(ray);
        if (!is_compared[i] || ray.escape_margin() < 0) continue;
        expected[i] = reference_end(ray, beyond);
        EXPECT_TRUE(expected[i]) << "ray " << i;
    }
    int compared = 0;
    for (const char* strategy : strategies) {
        const auto ends = traced(*plan_for_rays(scene, observer, strategy), starts);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (!is_compared[i]) continue;
            EXPECT_EQ(ends[i].status, expected[i] ? status : Status::captured) << strategy << ", ray " << i;
            if (ends[i].status != status || !expected[i]) continue;
            const double error = distance_between(expected[i]->place, ends[i]);
            EXPECT_LT(error, tolerance * expected[i]->conditioning) << strategy << ", ray " << i;
            ++compared;
        }
    }
    return compared;
}

/// Returns rays in all directions from different places at the radius r.
std::vector<RayInput> rays_from_radius(double spin, double r, int count) {
    std::vector<RayInput> rays;
    for (const Double3& d : even_directions(count)) {
        const int i = int(rays.size());
        rays.push_back({position_at(spin, r, 0.1 + 2.9 * i / count, 1.9 * i), d});
    }
    return rays;
}
/// Returns rays from r = 10 that pass the hole at different distances.
std::vector<RayInput> rays_from_afar(double spin, int count) {
    std::vector<RayInput> rays = rays_from_radius(spin, 10, count);
    for (RayInput& ray : rays)
        for (std::size_t k = 0; k < 3; ++k) ray.direction[k] = 0.8 * ray.direction[k] - ray.position[k] / 10;
    return rays;
}

class RaysOfObserver : public testing::TestWithParam<const char*> {};

TEST_P(RaysOfObserver, FromAfarMatchBoyerLindquist) {
    for (const double spin : {0.5, 0.95, 0.9999, -0.9}) {
        SCOPED_TRACE(testing::Message() << "spin " << spin);
        const auto rays = rays_from_afar(spin, 24);
        EXPECT_GT(compare_with_reference(scene_with_hole(spin), GetParam(), rays, beyond_sphere(40), Status::escaped),
                  16);
        EXPECT_GT(compare_with_reference(scene_with_hole(spin, walls(12)), GetParam(), rays, beyond_cube(12),
                                         Status::hit),
                  16);
    }
}

// Static observers, and rays without an observer, exist only outside the ergosphere.
TEST_P(RaysOfObserver, FromNearTheHorizonMatchBoyerLindquist) {
    int ends = 0;
    for (const double spin : {0.5, 0.95, 0.9999, -0.9})
        for (const double height : {0.05, 0.2, 0.5, 0.9}) {
            SCOPED_TRACE(testing::Message() << "spin " << spin << ", r = " << 1 + height << " horizon radii");
            const auto rays = rays_from_radius(spin, (1 + height) * (1 + std::sqrt(1 - spin * spin)), 24);
            ends += compare_with_reference(scene_with_hole(spin), GetParam(), rays, beyond_sphere(40), Status::escaped);
            ends +=
                compare_with_reference(scene_with_hole(spin, walls(6)), GetParam(), rays, beyond_cube(6), Status::hit);
        }
    EXPECT_GT(ends, 300);
}

INSTANTIATE_TEST_SUITE_P(Observers, RaysOfObserver, testing::Values("static", "zamo", "falling", ""),
                         [](const auto& chosen) { return *chosen.param ? std::string(chosen.param) : "none"; });

// The sphere in which charts change is smaller if a surface is near the horizon. Rays that pass the ball are the same.
TEST(RaysPastABallNearTheHorizon, MatchBoyerLindquist) {
    for (const double spin : {0.5, 0.9999})
        for (const char* observer : {"zamo", "falling"}) {
            SCOPED_TRACE(testing::Message() << "spin " << spin << ", " << observer);
            const std::string ball =
                "[[object]]\nname = \"ball\"\nshape = \"sphere\"\ncenter = [0, 2.6, 0]\nradius = 0.2\n";
            const auto rays = rays_from_radius(spin, 1.2 * (1 + std::sqrt(1 - spin * spin)), 48);
            const auto plan = plan_for_rays(scene_with_hole(spin, ball), observer);
            std::vector<RayInput> passing;
            const auto ends = traced(*plan, start_rays(*plan, rays, observer_of(observer)));
            for (std::size_t i = 0; i < rays.size(); ++i)
                if (ends[i].status != Status::hit) passing.push_back(rays[i]);
            EXPECT_GT(compare_with_reference(scene_with_hole(spin, ball), observer, passing, beyond_sphere(40),
                                             Status::escaped),
                      20);
        }
}

// A change of the chart restarts the method. The tolerances of methods with fixed steps are measured.
TEST(RaysByOtherMethods, MatchBoyerLindquist) {
    struct Setting {
        const char* text;
        double tolerance;
    };
    for (const auto& [text, tolerance] : {Setting{"method = \"rkf78\"\ntolerance = 1e-10", 1e-10},
                                          {"method = \"dp54\"\ntolerance = 1e-10", 1e-9},
                                          {"method = \"gauss12\"\nstep = 0.05", 1e-10},
                                          {"method = \"kahan-li8\"\nstep = 0.05", 1e-7}})
        for (const double spin : {0.5, 0.9999}) {
            SCOPED_TRACE(testing::Message() << "spin " << spin << ", " << text);
            std::string scene = scene_with_hole(spin);
            scene.insert(scene.find("escape_radius"), std::string(text) + "\n");
            const auto rays = rays_from_radius(spin, 1.3 * (1 + std::sqrt(1 - spin * spin)), 24);
            EXPECT_GT(compare_with_reference(scene, "zamo", rays, beyond_sphere(40), Status::escaped, tolerance), 8);
        }
}

// A falling observer inside the horizon sees the walls of a room outside.
TEST(RaysFromInside, HitARoomOutside) {
    for (const double spin : {0.0, 0.5, 0.9, -0.9})
        for (const double depth : {0.97, 0.6})
            for (const double theta : {0.0, 0.4, 1.2}) {
                const double r = depth * (1 + std::sqrt(1 - spin * spin));
                SCOPED_TRACE(testing::Message() << "spin " << spin << ", r = " << r << ", theta " << theta);
                std::vector<RayInput> rays;
                for (const Double3& d : even_directions(24)) rays.push_back({position_at(spin, r, theta, 0.7), d});
                EXPECT_GT(compare_with_reference(scene_with_hole(spin, walls(6)), "falling", rays, beyond_cube(6),
                                                 Status::hit),
                          32);
            }
}

/// A camera at r = 10 of a hole of spin 0.95, and a ball on the x axis.
std::unique_ptr<Plan> plan_with_moon(const char* observer, const char* strategy, const std::string& radius) {
    const std::string scene =
        "space = { hamiltonian = \"kerr\", spin = 0.95 }\n[integrator]\nescape_radius = 100\n[camera]\n"
        "position = [0, -10, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\nfov = 90\n[film]\nsize = [320, 240]\n"
        "[[object]]\nname = \"moon\"\nshape = \"sphere\"\ncenter = [3, 0, 0]\nradius = " +
        radius + "\n";
    return plan_of_text(scene, {std::string("camera.observer=") + observer}, with_strategy(strategy));
}
double impact_parameter(const RayStart& ray) { return (ray.q[0] * ray.p[1] - ray.q[1] * ray.p[0]) / ray.pt; }

/// L/p_t of the ray from that camera to the centre of the ball, from the integral of dφ/dr in outgoing coordinates with
/// 20 digits.
constexpr double impact_parameter_of_moon = 5.51449174124;

// The camera and the ball stay where they are, whichever observer looks: the impact parameter of the ray to the centre
// of the ball's image is the same. The bound is half a pixel.
TEST(PicturesOfABall, HaveTheSameGeometryForAllObservers) {
    for (const char* observer : {"static", "zamo", "falling"}) {
        const auto plan = plan_with_moon(observer, "packet", "0.3");
        std::vector<RayStart> starts;
        for (std::uint32_t i = 0; i < 320 * 240; ++i) starts.push_back(pixel_ray_start(*plan, i % 320, i / 320));
        const auto ends = traced(*plan, starts);
        double x = 0, y = 0, pixels = 0;
        for (std::uint32_t i = 0; i < ends.size(); ++i) {
            if (ends[i].status != Status::hit || i % 320 < 160) continue;  // The second image is on the left side.
            x += i % 320 + 0.5;
            y += double(i / 320) + 0.5;
            ++pixels;
        }
        ASSERT_GT(pixels, 20) << observer;
        const auto impact_at = [&](double offset) {
            return impact_parameter(camera_ray_start(*plan, x / pixels + offset, y / pixels));
        };
        EXPECT_GT(impact_parameter_of_moon, impact_at(-0.5)) << observer;
        EXPECT_LT(impact_parameter_of_moon, impact_at(0.5)) << observer;
    }
}

// The same with a ball of radius 0.001, which is hit by rays within 6e-4 of this impact parameter, because dφ/dL is
// 0.58 and the ball is at r = 2.8.
TEST(PicturesOfABall, ShowATinyBallInTheExactDirection) {
    for (const char* observer : {"static", "zamo", "falling"})
        for (const char* strategy : strategies) {
            const auto plan = plan_with_moon(observer, strategy, "0.001");
            std::vector<RayStart> starts;
            for (const double difference : {-1.2e-3, -3e-4, 0.0, 3e-4, 1.2e-3}) {
                double low = 160, high = 320;
                for (int i = 0; i < 60; ++i) {
                    const double x = 0.5 * (low + high);
                    const bool is_beyond =
                        impact_parameter(camera_ray_start(*plan, x, 120)) > impact_parameter_of_moon + difference;
                    (is_beyond ? high : low) = x;
                }
                starts.push_back(camera_ray_start(*plan, low, 120));
            }
            const auto ends = traced(*plan, starts);
            for (std::size_t i = 0; i < ends.size(); ++i)
                EXPECT_EQ(ends[i].status == Status::hit, i > 0 && i < 4) << observer << ' ' << strategy << ' ' << i;
        }
}

}  // namespace
}  // namespace kagero::test
