// Tests of the layer `magnification`: the solid angle of a pixel divided by that of its footprint on the sky. For
// straight rays the magnification is 1. Around a black hole it is compared with elliptic integrals.
#include "film/film.h"
#include "tests/support/plan_fixture.h"
#include "tests/support/schwarzschild_orbit.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace kagero::test {
namespace {

std::string scene(const std::string& space, const std::string& camera) {
    return "[space]\n" + space +
           "[integrator]\nescape_radius = 1000\n[camera]\nposition = [-10, 0, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, "
           "1]\n" +
           camera + "[film]\nsize = [256, 128]\nlayers = [\"status\", \"footprint\", \"magnification\"]\n";
}

Film rendered(const Plan& plan) {
    Film film = film_of(plan);
    render(plan, film);
    return film;
}

TEST(Magnification, IsOneForStraightRays) {
    for (const char* camera : {"fov = 20\n", "type = \"equirectangular\"\n"}) {
        const auto plan = plan_of_text(scene("hamiltonian = \"flat\"\n", camera), {});
        Film film = rendered(*plan);
        for (std::uint32_t y = 0; y < 128; ++y)
            for (std::uint32_t x = 0; x < 256; x += 7)
                ASSERT_NEAR(*film.pixel("magnification", x, y), 1, 0.001) << camera << x << "," << y;
    }
}

// The fields of view are wide and the pixels are large, so that perspective distorts the pixels in the corners.
TEST(Magnification, IsOneForWidePixels) {
    for (const char* camera : {"fov = 60\n", "fov = 120\n", "type = \"equirectangular\"\n"}) {
        const auto plan = plan_of_text(scene("hamiltonian = \"flat\"\n", camera), {"film.size=[64,48]"});
        Film film = rendered(*plan);
        for (std::uint32_t y = 0; y < 48; ++y)
            for (std::uint32_t x = 0; x < 64; ++x)
                ASSERT_NEAR(*film.pixel("magnification", x, y), 1, 0.001) << camera << x << "," << y;
    }
}

// The film has an odd number of rows and columns. The last blocks of 2 × 2 pixels extend beyond it.
TEST(Magnification, IsOneInTheLastRowAndColumn) {
    for (const char* camera : {"fov = 20\n", "type = \"equirectangular\"\n"}) {
        const auto plan = plan_of_text(scene("hamiltonian = \"flat\"\n", camera), {"film.size=[61,41]"});
        Film film = rendered(*plan);
        for (std::uint32_t y = 0; y < 41; ++y)
            ASSERT_NEAR(*film.pixel("magnification", 60, y), 1, 0.001) << camera << y;
        for (std::uint32_t x = 0; x < 61; ++x)
            ASSERT_NEAR(*film.pixel("magnification", x, 40), 1, 0.001) << camera << x;
    }
}

// At the edge of an object, only two or three pixels of a block of 2 × 2 show the sky.
TEST(Magnification, IsOneAtEdgesOfObjects) {
    const auto plan = plan_of_text(scene("hamiltonian = \"flat\"\n", "fov = 20\n") +
                                       "[[object]]\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1.1\n",
                                   {"film.size=[31,21]"});
    Film film = rendered(*plan);
    int compared = 0, at_edges = 0;
    for (std::uint32_t y = 0; y < 21; ++y)
        for (std::uint32_t x = 0; x < 31; ++x) {
            const double m = *film.pixel("magnification", x, y);
            if (*film.pixel("status", x, y) != float(static_cast<int>(Status::escaped)) || m == 0)
                continue;  // 0: no other pixel of the block shows the sky
            const bool complete_block = [&] {
                for (const std::uint32_t k : {0u, 1u, 2u, 3u}) {
                    const std::uint32_t i = (x & ~1u) + k % 2, j = (y & ~1u) + k / 2;
                    if (i > 30 || j > 20 || *film.pixel("status", i, j) != *film.pixel("status", x, y)) return false;
                }
                return true;
            }();
            ++compared;
            at_edges += !complete_block;
            EXPECT_NEAR(m, 1, 0.05) << x << ',' << y;
        }
    EXPECT_GT(compared, 500);
    EXPECT_GT(at_edges, 50);
}

TEST(Magnification, IsZeroForAnOrthographicCamera) {
    const auto plan = plan_of_text(scene("hamiltonian = \"flat\"\n", "type = \"orthographic\"\nheight = 4\n"), {});
    Film film = rendered(*plan);
    EXPECT_EQ(*film.pixel("magnification", 100, 50), 0);
    EXPECT_NEAR(*film.pixel("footprint", 100, 50), 0, 1e-12);
}

constexpr double observer_radius = 10, far_radius = 1000;

/// Returns the angle β on the sky between a source of light and the point exactly behind the hole. A static observer
/// sees the light of the source at the angle psi from the centre of the hole.
double sky_angle(double psi) {
    const double b = observer_radius * std::sin(psi) / std::sqrt(1 - 1 / observer_radius), u = 1 / far_radius;
    const Orbit orbit(b);
    const double swept = 0.5 * (orbit.swept_around(observer_radius) + orbit.swept_around(far_radius));
    return swept + std::atan2(u, std::sqrt(1 / (b * b) - u * u * (1 - u))) - std::numbers::pi;
}

// The magnification is sin ψ / |sin β dβ/dψ| with the source angle β(ψ).
TEST(Magnification, MatchesEllipticIntegralsAroundABlackHole) {
    const auto plan = plan_of_text(scene("hamiltonian = \"schwarzschild\"\nrg = 1\n", "fov = 30\n"), {});
    Film film = rendered(*plan);
    const double pixel = 2 * std::tan(std::numbers::pi / 12) / 128;
    int compared = 0;
    for (std::uint32_t y = 0; y < 128; y += 3)
        for (std::uint32_t x = 0; x < 256; x += 5) {
            // The footprint is fitted to a block of 2 × 2 pixels, so that it belongs to the middle of the block.
            const double u = ((x & ~1u) + 1.0 - 128) * pixel, v = ((y & ~1u) + 1.0 - 64) * pixel,
                         psi = std::atan(std::hypot(u, v));
            if (psi < 0.38 || *film.pixel("status", x, y) != 1) continue;
            const double h = 1e-4, slope = (sky_angle(psi + h) - sky_angle(psi - h)) / (2 * h);
            const double expected = std::sin(psi) / std::abs(std::sin(sky_angle(psi)) * slope);
            if (expected > 8) continue;  // near the Einstein ring, a block covers a large part of the sky
            const double pixel_cosine =
                             std::cos(std::atan(std::hypot((x + 0.5 - 128) * pixel, (y + 0.5 - 64) * pixel))),
                         block_cosine = std::cos(psi);
            // The solid angle of a pixel is proportional to the cube of the cosine.
            const double measured =
                *film.pixel("magnification", x, y) * std::pow(block_cosine / pixel_cosine, 3);
            EXPECT_NEAR(measured / expected, 1, 0.02) << x << "," << y << " " << psi << " " << expected;
            ++compared;
        }
    EXPECT_GT(compared, 200);
}

// On the Einstein ring, a block of pixels shows two sides of the sky. The magnification must nevertheless be the same,
// within a factor of 1.6, for any number of rays per pixel.
TEST(Magnification, DoesNotDependOnTheNumberOfRaysPerPixel) {
    const auto magnifications = [](const char* spp) {
        const auto plan =
            plan_of_text(scene("hamiltonian = \"schwarzschild\"\nrg = 1\n", "fov = 30\n"), {"film.size=[96,48]", spp});
        Film film = rendered(*plan);
        std::vector<double> all;
        const double pixel = 2 * std::tan(std::numbers::pi / 12) / 48;
        for (std::uint32_t y = 0; y < 48; ++y)
            for (std::uint32_t x = 0; x < 96; ++x)
                if (std::hypot(x + 0.5 - 48, y + 0.5 - 24) * pixel > 0.38)
                    all.push_back(*film.pixel("magnification", x, y));
        return all;
    };
    const auto one_ray = magnifications("film.spp=1");
    EXPECT_GT(*std::max_element(one_ray.begin(), one_ray.end()), 5);
    for (const char* spp : {"film.spp=2", "film.spp=4", "film.spp=16"}) {
        const auto many_rays = magnifications(spp);
        for (std::size_t i = 0; i < one_ray.size(); ++i)
            ASSERT_LT(std::abs(std::log(many_rays[i] / one_ray[i])), std::log(1.6))
                << spp << " " << i << " " << one_ray[i];
    }
}

}  // namespace
}  // namespace kagero::test
