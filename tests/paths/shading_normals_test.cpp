// Tests of vertex normals on diffuse meshes, against closed forms.
#include "tests/support/plan_fixture.h"

#include "render/render.h"

#include <gtest/gtest.h>

namespace kagero::test {
namespace {

constexpr double tilt = 0.6;  ///< Angle of the vertex normals from the normal of the triangles, in radians.

/// A scene that shows a square in the plane z = 0 from a height of 3, or from below. All vertex normals are
/// (±sin, 0, ±cos) of the tilt. With `scale` = −1, they point below the square.
class ShadingNormals : public ::testing::TestWithParam<std::string> {
protected:
    void SetUp() override {
        file_ = std::filesystem::temp_directory_path() / ("kagero-square-" + std::to_string(::getpid()) + ".obj");
    }
    void TearDown() override { std::filesystem::remove(file_); }

    /// Returns the mean of the picture, and its standard error.
    std::array<double, 2> light(const std::string& objects, double scale, double side, bool has_normals = true) {
        std::ostringstream obj;
        obj << "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nvn " << scale * std::sin(tilt) << " 0 "
            << scale * std::cos(tilt) << (has_normals ? "\nf 1//1 2//1 3//1 4//1\n" : "\nf 1 2 3 4\n");
        std::ofstream(file_) << obj.str();
        const std::string z = std::to_string(3 * side);
        const auto plan = plan_of_text(
            "[space]\n" + GetParam() + "[camera]\nposition = [0, 0, " + z +
                "]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\nfov = 1\n[film]\nsize = [16, 16]\nspp = 256\n"
                "max_bounces = 1\nlayers = [\"color\", \"standard_error\"]\n[[object]]\nname = \"square\"\n"
                "shape = \"mesh\"\nfile = \"" +
                file_.string() + "\"\ncolor = [0.5, 0.5, 0.5]\nmaterial = \"diffuse\"\n" + objects,
            {});
        Film film = film_of(*plan);
        render(*plan, film);
        double sum = 0, square = 0;
        constexpr std::size_t pixels = 16 * 16;
        for (std::size_t i = 0; i < pixels; ++i) {
            sum += double(film.plane("color")[3 * i]) / pixels;
            square += std::pow(double(film.plane("standard_error")[3 * i]) / pixels, 2);
        }
        return {sum, std::sqrt(square)};
    }

    std::filesystem::path file_;
};

const std::string lamp =
    "[[object]]\nname = \"lamp\"\nshape = \"sphere\"\ncenter = [4, 0, 4]\nradius = 0.3\ncolor = [50, 50, 50]\n";

/// The irradiance of a sphere above both horizons is π L sin²α cos θ, with the angle θ from the shading normal.
TEST_P(ShadingNormals, DetermineTheBrightness) {
    const double sine_squared = 0.09 / 32, quarter = std::atan(1.0);
    const auto expected = [&](double angle) { return 0.5 * 50 * sine_squared * std::cos(angle); };
    for (const double scale : {1.0, -1.0}) {  // the normals are turned to the side of the ray
        const auto [mean, error] = light(lamp, scale, 1);
        EXPECT_LT(error, 0.005 * mean);
        EXPECT_NEAR(mean, expected(quarter - tilt), 4 * error + 2e-3 * mean);  // the square is seen at up to x = 0.03
    }
    const auto [flat, flat_error] = light(lamp, 1, 1, false);
    EXPECT_NEAR(flat, expected(quarter), 4 * flat_error + 2e-3 * flat);
}

/// Under an even sky, the light of directions below the triangle is lost: the share (1 + cos tilt)/2 remains.
TEST_P(ShadingNormals, AdmitNoLightFromBelowTheTriangle) {
    const auto [mean, error] = light("[sky]\ncolor = [2, 2, 2]\n", 1, 1);
    EXPECT_LT(error, 0.005 * mean);
    EXPECT_NEAR(mean, 0.5 * 2 * 0.5 * (1 + std::cos(tilt)), 4 * error);
}

/// From below, the square is dark if the only lamp is above it.
TEST_P(ShadingNormals, LeaveTheSideToTheTriangle) { EXPECT_EQ(light(lamp, 1, -1)[0], 0); }

// The second space is a black hole so small that it bends nothing. Its rest frames and null rays are used.
INSTANTIATE_TEST_SUITE_P(Spaces, ShadingNormals,
                         ::testing::Values("hamiltonian = \"flat\"\n",
                                           "hamiltonian = \"schwarzschild\"\nrg = 1e-6\ncenter = [0, 0, -30]\n",
                                           "hamiltonian = \"kerr\"\nmass = 1e-6\nspin = 0.5\ncenter = [0, 0, -30]\n"));

}  // namespace
}  // namespace kagero::test
