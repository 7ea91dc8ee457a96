// A diffuse floor that a small lamp lights around a black hole, against the result of an independent script:
// tests/paths/lensed_floor.py, whose result is tests/paths/lensed_floor.json, with the command that computes it. The
// environment variable KAGERO_SPP is the number of rays per pixel (default 256). With 65536, kagero's error is small
// enough to show that both agree to 0.5 %.
#include "tests/support/plan_fixture.h"

#include "render/render.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdlib>
#include <iostream>

namespace kagero::test {
namespace {

/// The scene of the script, seen from a small height above the point (x, 0, −1) of the floor.
std::string lensed_floor(double x, int spp) {
    const std::string place = std::to_string(x);
    return "[space]\nhamiltonian = \"schwarzschild\"\nrg = 0.12\n[camera]\ntype = \"orthographic\"\nposition = [" +
           place + ", 0, -0.95]\nlook_at = [" + place +
           ", 0, -1]\nup = [0, 1, 0]\nheight = 0.004\n[film]\nsize = [24, 24]\nspp = " +
           std::to_string(spp) +
           "\nmax_bounces = 1\n"
           "layers = [\"color\", \"standard_error\"]\n"
           "[[object]]\nname = \"floor\"\nshape = \"rectangle\"\norigin = [-50, -50, -1]\nedge_u = [100, 0, 0]\n"
           "edge_v = [0, 100, 0]\ncolor = [0.6, 0.6, 0.6]\nmaterial = \"diffuse\"\n"
           "[[object]]\nname = \"lamp\"\nshape = \"sphere\"\ncenter = [0.15, 0.1, 0.9]\nradius = 0.2\n"
           "color = [10, 10, 10]\n";
}

TEST(LensedFloor, HasTheLightOfTheIndependentScript) {
    const auto stored = nlohmann::json::parse(std::ifstream(KAGERO_SOURCE "/tests/paths/lensed_floor.json"));
    EXPECT_GE(3 * stored["paths"].get<double>(), 1e8);
    const char* wanted = std::getenv("KAGERO_SPP");
    const int spp = wanted ? std::atoi(wanted) : 256;
    for (const auto& point : stored["points"]) {
        const double x = point["x"], expected = point["light"], expected_error = point["error"];
        const auto plan = plan_of_text(lensed_floor(x, spp), {});
        Film film = film_of(*plan);
        render(*plan, film);
        const std::size_t pixels = std::size_t(film.width()) * film.height();
        double mean = 0, square = 0;
        for (std::size_t i = 0; i < pixels; ++i) {
            mean += double(film.plane("color")[3 * i]) / double(pixels);
            square += std::pow(double(film.plane("standard_error")[3 * i]) / double(pixels), 2);
        }
        // Light without the hole, in the closed form of a sphere above the horizon.
        const double dx = 0.15 - x, dy = 0.1, dz = 1.9, distance_squared = dx * dx + dy * dy + dz * dz;
        const double straight = 0.6 * 10 * 0.04 / distance_squared * dz / std::sqrt(distance_squared);
        EXPECT_GT(std::abs(expected / straight - 1), 0.02) << "the hole changes the light";
        EXPECT_LT(expected_error, 0.0025 * expected);
        const double error = std::sqrt(square + expected_error * expected_error);
        EXPECT_LT(error, 0.04 * expected);
        EXPECT_NEAR(mean, expected, 4 * error) << "x = " << x;
        if (wanted)
            std::cout << "x = " << x << ": " << 100 * (mean / expected - 1) << " +- " << 100 * error / expected
                      << " %\n";
        if (error < 0.003 * expected) {
            EXPECT_NEAR(mean, expected, 0.005 * expected) << "x = " << x;
        }
    }
}

}  // namespace
}  // namespace kagero::test
