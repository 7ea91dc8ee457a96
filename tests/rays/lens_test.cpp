// Tests of cameras with a thin lens, against the closed form of the circle of confusion.
#include "tests/support/plan_fixture.h"

#include "rays/list_rays.h"
#include "render/render.h"
#include "scene/vector3.h"

#include <gtest/gtest.h>

#include <numbers>

namespace kagero::test {
namespace {

std::string scene_with_lens(const std::string& space, const std::string& camera, const std::string& objects = "") {
    return "[space]\n" + space + "[camera]\nposition = [0, -5, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\nfov = 20\n" +
           camera + "[film]\nsize = [64, 64]\nspp = 64\n" + objects;
}
const std::string flat_space = "hamiltonian = \"flat\"\n", lens_keys = "aperture_radius = 0.3\nfocus_distance = 5\n";

/// A small bright ball at a distance from the camera.
std::string dot_at(double distance) {
    return "[[object]]\nname = \"dot\"\nshape = \"sphere\"\ncenter = [0, " + std::to_string(distance - 5) +
           ", 0]\nradius = " + std::to_string(0.008 * distance) + "\ncolor = [1e4, 1e4, 1e4]\n";
}

// A point at the distance D is a disk of light with the angular radius R |1/D − 1/F|, as seen from the lens. Its mean
// square radius is half of the square. The ball adds half of the square of its own radius, and the pixel its variance.
// The tolerance of 0.15 square pixels is that of sums over pixels of a disk that is three pixels wide.
TEST(Lens, ShowsTheCircleOfConfusion) {
    const double pixel = 2 * std::tan(10 * std::numbers::pi / 180) / 64;
    for (const std::string& space : {flat_space, std::string("hamiltonian = \"uniform\"\nn0 = 1.5\n"),
                                     std::string("hamiltonian = \"schwarzschild\"\nrg = 1e-6\ncenter = [40, -5, 0]\n")})
        for (const double distance : {3.5, 5.0, 9.0}) {
            const auto plan =
                plan_of_text(scene_with_lens(space, lens_keys, dot_at(distance)), {"integrator.escape_radius=200"});
            Film film = film_of(*plan);
            render(*plan, film);
            double sum = 0, square = 0;
            for (int i = 0; i < 64 * 64; ++i) {
                const double x = i % 64 - 31.5, y = i / 64 - 31.5, light = film.plane("color")[3 * i];
                sum += light;
                square += light * (x * x + y * y);
            }
            const double circle = 0.3 * std::abs(1 / distance - 1 / 5.0) / pixel, ball = 0.008 / pixel;
            EXPECT_NEAR(square / sum, 0.5 * (circle * circle + ball * ball) + 1.0 / 6, 0.04 * circle * circle + 0.15)
                << space << distance;
        }
}

// All rays of a point of the picture meet at the focus distance. Their starts fill the disk of the lens evenly.
TEST(Lens, FocusesRays) {
    const auto plan = plan_of_text(scene_with_lens(flat_space, lens_keys), {});
    const CameraRay pinhole = camera_ray(*plan, 10.3, 50.1);
    const Double3 direction{pinhole.start.p[0], pinhole.start.p[1], pinhole.start.p[2]};
    const Double3 focus = add({0, -5, 0}, scaled(direction, 5 / direction[1]));
    for (const std::array<double, 2>& point : {std::array{0.0, 0.0}, std::array{1.0, 0.0}, std::array{-0.3, 0.6}}) {
        const RayStart start = lens_ray(*plan, 10.3, 50.1, point).start;
        const Double3 q{start.q[0], start.q[1], start.q[2]}, p{start.p[0], start.p[1], start.p[2]};
        EXPECT_NEAR(length(subtract(q, {0.3 * point[0], -5, -0.3 * point[1]})), 0, 1e-14);
        EXPECT_NEAR(length(cross(unit(subtract(focus, q)), unit(p))), 0, 1e-14);
    }
    RayList list;
    list_rays(*plan, {3, 4, 4, 5}, list);
    double mean_square = 0;  // of the 64 rays of the pixel
    for (const RayStart& start : list.starts) mean_square += (start.q[0] * start.q[0] + start.q[2] * start.q[2]) / 64;
    EXPECT_NEAR(mean_square, 0.5 * 0.09, 0.006);
}

// In a strong field, the lens is a disk in the rest frame of the observer: its radius is 0.3 in proper length.
TEST(Lens, IsADiskInTheRestFrame) {
    const std::string hole = "hamiltonian = \"schwarzschild\"\nrg = 2\ncenter = [0, -12, 0]\n";
    const auto plan = plan_of_text(scene_with_lens(hole, "aperture_radius = 0.01\n"), {});
    // The radial direction is stretched in Kerr–Schild coordinates; across it, coordinate lengths are proper lengths.
    EXPECT_NEAR(length(plan->view.lens_right), 0.01, 1e-12);
    EXPECT_NEAR(length(plan->view.lens_down), 0.01, 1e-12);
    const auto across = plan_of_text(scene_with_lens(hole, "aperture_radius = 0.01\n"), {"camera.look_at=[5, -5, 0]"});
    // The metric of a static observer is dl² = dr²/(1 − r_g/r) along the radius.
    const double r = 7, radial = 0.01 * std::sqrt(1 - 2 / r);
    EXPECT_NEAR(length(across->view.lens_right), radial, 1e-10);
    EXPECT_NEAR(length(across->view.lens_down), 0.01, 1e-12);
}

TEST(Lens, RefusesBadInput) {
    const auto refusal = [](const std::string& camera, const std::string& objects = "") {
        try {
            plan_of_text(scene_with_lens(flat_space, camera, objects), {});
        } catch (const InputError& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_NE(refusal("aperture_radius = -1\n").find("0 <= value"), std::string::npos);
    EXPECT_NE(refusal("aperture_radius = 0.1\nfocus_distance = 0\n").find("camera.focus_distance"), std::string::npos);
    EXPECT_NE(refusal("type = \"orthographic\"\naperture_radius = 0.1\n").find("perspective"), std::string::npos);
    EXPECT_NE(refusal("aperture_radius = 2\n", dot_at(1)).find("nearest surface"), std::string::npos);
    EXPECT_EQ(refusal("type = \"orthographic\"\naperture_radius = 0\n"), "");
}

}  // namespace
}  // namespace kagero::test
