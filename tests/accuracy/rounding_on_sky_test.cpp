// Tests of the layer `rounding_error` where distant observers with a velocity see the sky: aberration changes the size
// of errors on the sky.
#include "tests/support/plan_fixture.h"

#include "accuracy/end_errors.h"
#include "accuracy/ray_errors.h"
#include "film/film.h"
#include "rays/camera.h"
#include "render/trace.h"
#include "scene/value.h"
#include "scene/vector3.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kagero::test {
namespace {

constexpr std::uint32_t size = 12;

/// A flat spacetime as a formula, whose rays are integrated.
const std::string flat = R"toml([space]
hamiltonian = "formula"
H = "0.5*(px^2 + py^2 + pz^2 - pt^2)"
[space.constants]
pt = 1
[integrator]
method = "dp85"
tolerance = 1e-8
escape_radius = 20
[camera]
position = [0.3, -1, 0.2]
look_at = [0.3, 9, 0.2]
up = [0, 0, 1]
fov = 120
[film]
size = [12, 12]
layers = ["rounding_error"]
)toml";

/// A static metric with a different gradient in every direction, whose distant observers move differently everywhere.
const std::string uneven = R"toml([space]
hamiltonian = "formula"
H = "0.5*((px^2 + py^2 + pz^2)/(1 + 0.3*exp(-x^2 - 0.5*y^2)) - (pt + 0.2*px*sin(0.1*z))^2*(1 + 0.1*cos(0.2*x)))"
sky_frame = ["0.3*cos(0.1*y)", "0.2*sin(0.1*x)", 0.4]
[space.constants]
pt = 1
[integrator]
method = "dp85"
tolerance = 1e-10
escape_radius = 20
[camera]
position = [0.3, -1, 0.2]
look_at = [0.3, 9, 0.2]
up = [0, 0, 1]
fov = 120
[film]
size = [12, 12]
layers = ["rounding_error"]
)toml";

/// Returns the layer `rounding_error` of a picture.
std::vector<float> bounds_of(const Plan& plan) {
    Film film(size, size, {"rounding_error"});
    render_with_errors(plan, film);
    const float* first = static_cast<const Film&>(film).plane("rounding_error");
    return {first, first + size * size};
}

/// Returns the ends of the rays of all pixels, in the coordinates of the Hamiltonian.
std::vector<RayEnd> ends_of_pixels(const Plan& plan) {
    std::vector<RayStart> starts;
    for (std::uint32_t y = 0; y < size; ++y)
        for (std::uint32_t x = 0; x < size; ++x) starts.push_back(pixel_ray_start(plan, x, y));
    std::vector<RayEnd> ends;
    trace(plan, starts, ends);
    for (RayEnd& end : ends) end = to_hamiltonian_coordinates(plan, end);
    return ends;
}

// Aberration is conformal: it magnifies angles by 1/(γ (1 − v·n)), where n is the direction in which the light moves
// (Einstein 1905, §7). The bound of every pixel is magnified by this factor. The bound is a sum of absolute values over
// two axes, which the aberration may rotate; this changes it by at most √2.
TEST(RoundingOnSky, IsMagnifiedByTheAberration) {
    const auto at_rest = plan_of_text(flat, {});
    const std::vector<float> expected = bounds_of(*at_rest);
    const std::vector<RayEnd> ends = ends_of_pixels(*at_rest);
    for (const Double3& velocity : {Double3{0, 0.9, 0}, Double3{0, -0.9, 0}, Double3{0.5, 0.3, -0.6}}) {
        SCOPED_TRACE(to_toml(velocity));
        const std::vector<float> bounds = bounds_of(*plan_of_text(flat, {{"space.sky_frame=" + to_toml(velocity)}}));
        double least = 1e9, greatest = 0;
        for (std::size_t i = 0; i < bounds.size(); ++i) {
            const Double3 d{ends[i].v[0], ends[i].v[1], ends[i].v[2]};
            const double magnification = std::sqrt(1 - dot(velocity, velocity)) / (1 + dot(velocity, d)),
                         ratio = bounds[i] / (magnification * expected[i]);
            EXPECT_GT(ratio, 0.7) << i;
            EXPECT_LT(ratio, 1.42 * std::max(1.0, 1 / ratio)) << i;
            least = std::min(least, magnification);
            greatest = std::max(greatest, magnification);
        }
        EXPECT_GT(greatest, 1.3 * least);
    }
}

// The derivatives of the seen direction are compared with differences between rays: neighbours of a pixel's ray, traced
// in the same way, end at other positions with other directions and momenta.
TEST(RoundingOnSky, DerivativesAgreeWithNeighbouringRays) {
    const auto plan = plan_of_text(uneven, {});
    const Skies& skies = plan->scene->sources.skies;
    constexpr double offset = 1e-3;  // pixels
    int compared = 0;
    double by_position = 0;
    for (std::uint32_t y = 0; y < size; y += 3)
        for (std::uint32_t x = 0; x < size; x += 3) {
            std::vector<RayStart> starts;
            for (const auto& [dx, dy] :
                 {std::pair{0.0, 0.0}, {offset, 0.0}, {-offset, 0.0}, {0.0, offset}, {0.0, -offset}})
                starts.push_back(camera_ray_start(*plan, x + 0.5 + dx, y + 0.5 + dy));
            std::vector<RayEnd> ends;
            trace(*plan, starts, ends);
            for (RayEnd& end : ends) end = to_hamiltonian_coordinates(*plan, end);
            const auto derivatives = sky_derivatives(skies, ends[0]);
            ASSERT_TRUE(derivatives);
            for (std::size_t pair = 1; pair < 5; pair += 2) {
                const RayEnd &a = ends[pair], &b = ends[pair + 1];
                const Double3 actual = subtract(sky_view(skies, a).direction, sky_view(skies, b).direction);
                Double3 predicted{}, from_position{};
                for (std::size_t k = 0; k < 3; ++k) {
                    from_position = add(from_position, scaled(derivatives->by_position[k], a.q[k] - b.q[k]));
                    predicted = add(predicted, scaled(derivatives->by_direction[k], a.v[k] - b.v[k]));
                }
                predicted = add(predicted, from_position);
                EXPECT_LT(length(subtract(actual, predicted)), 1e-5 * length(actual)) << x << ' ' << y;
                by_position = std::max(by_position, length(from_position) / length(actual));
                ++compared;
            }
        }
    EXPECT_EQ(compared, 32);
    EXPECT_GT(by_position, 0.01);  // so that the derivatives by position are tested too
}

}  // namespace
}  // namespace kagero::test
