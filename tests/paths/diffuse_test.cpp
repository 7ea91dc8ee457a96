// Tests of diffuse surfaces and of the layer standard_error, against closed forms.
#include "tests/support/plan_fixture.h"

#include "render/render.h"

#include <gtest/gtest.h>

#include <numeric>

namespace kagero::test {
namespace {

/// A room of albedo a that emits 1, from −1 to 1, and a camera in it.
std::string furnace(const std::string& space, double albedo, const std::string& film, const std::string& objects = "") {
    const std::string a = std::to_string(albedo);
    return "[space]\n" + space +
           "[camera]\nposition = [0.1, -0.8, 0.05]\nlook_at = [0, 1, 0]\nup = [0, 0, 1]\nfov = 80\n"
           "[film]\n" +
           film + "[[object]]\nname = \"room\"\nshape = \"room\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\n" + "color = [" +
           a + ", " + a + ", " + a + "]\nmaterial = \"diffuse\"\nemission_strength = " + std::to_string(1 / albedo) +
           "\n" + objects;
}

const std::string flat = "hamiltonian = \"flat\"\n";

/// A boundary with the medium `inside`.
std::string lens(const std::string& shape, const std::string& medium) {
    return "[[medium]]\nname = \"inside\"\n" + medium + "[[object]]\nname = \"lens\"\n" + shape +
           "material = \"boundary\"\ninterior = \"inside\"\n";
}
const std::string ball = "shape = \"sphere\"\ncenter = [0.2, 0.3, 0]\nradius = 0.4\n",
                  box = "shape = \"box\"\nmin = [-0.3, 0.1, -0.3]\nmax = [0.3, 0.6, 0.3]\n";

/// A rendered picture with its standard error, three numbers per pixel.
struct Rendered {
    std::vector<double> color, error;
};

Rendered render_scene(const std::string& scene, const Overrides& overrides = {}) {
    const auto plan = plan_of_text(scene, overrides);
    Film film = film_of(*plan);
    render(*plan, film);
    const std::size_t count = 3 * std::size_t(film.width()) * film.height();
    const float *color = film.plane("color"), *error = film.plane("standard_error");
    return {{color, color + count}, {error, error + count}};
}

double mean_of(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

/// Returns the standard error of the mean over all pixels of a grey picture.
double error_of_mean(const Rendered& picture) {
    double square = 0;
    for (std::size_t i = 0; i < picture.error.size(); i += 3) square += picture.error[i] * picture.error[i];
    return std::sqrt(square) / (double(picture.error.size()) / 3);
}

const std::string furnace_film =
    "size = [32, 24]\nspp = 64\nmax_bounces = 200\nlayers = [\"color\", \"standard_error\"]\n";

/// A closed room in equilibrium is uniformly bright, and what transmits or bends light in it cannot be seen: rays carry
/// the radiance divided by the squared index.
class Furnace : public ::testing::TestWithParam<std::array<std::string, 3>> {};

TEST_P(Furnace, IsUniform) {
    const auto& [name, space, objects] = GetParam();
    const double albedo = 0.5, expected = 1 / (1 - albedo);
    const Rendered picture = render_scene(furnace(space, albedo, furnace_film, objects));
    const double error = error_of_mean(picture);
    EXPECT_LT(error, 0.0017 * expected);
    EXPECT_NEAR(mean_of(picture.color), expected, std::min(3 * error, 0.005 * expected)) << name;
    // The spread of the pixels is that of their errors: nothing in the room is brighter than the rest.
    double spread = 0, predicted = 0;
    for (std::size_t i = 0; i < picture.color.size(); i += 3) {
        spread += std::pow(picture.color[i] - expected, 2);
        predicted += std::pow(picture.error[i], 2);
    }
    EXPECT_NEAR(std::sqrt(spread / predicted), 1, 0.1) << name;
}

INSTANTIATE_TEST_SUITE_P(
    Rooms, Furnace,
    ::testing::Values(
        std::array<std::string, 3>{"empty", flat, ""},
        std::array<std::string, 3>{"glass", flat, lens(ball, "hamiltonian = \"uniform\"\nn0 = 1.5\n")},
        std::array<std::string, 3>{"graded_ball", flat, lens(ball, "hamiltonian = \"gradient\"\nn0 = 1.5\ng = 0.8\n")},
        std::array<std::string, 3>{"graded_box", flat,
                                   lens(box, "hamiltonian = \"fisheye\"\nn0 = 1.8\nradius = 0.5\n")},
        std::array<std::string, 3>{"graded_space", "hamiltonian = \"gradient\"\nn0 = 1.5\ng = 0.5\n", ""},
        std::array<std::string, 3>{"glass_in_graded_space", "hamiltonian = \"gradient\"\nn0 = 1.5\ng = 0.5\n",
                                   lens(ball, "hamiltonian = \"uniform\"\nn0 = 1.2\n")},
        std::array<std::string, 3>{"anisotropic", "hamiltonian = \"formula\"\nH = \"(px^2 + 2*py^2 + pz^2 - 1)/2\"\n",
                                   ""}),
    [](const auto& test) { return test.param[0]; });

// The light of paths with at most n surfaces is the sum of the first n + 1 powers of the albedo. No lens adds any.
TEST(Diffuse, AddsThePowersOfTheAlbedo) {
    const std::string glass = lens(ball, "hamiltonian = \"uniform\"\nn0 = 1.5\n");
    double expected = 0;
    for (int bounces = 0; bounces < 3; ++bounces) {
        expected += std::pow(0.75, bounces);
        const std::string film = "size = [8, 6]\nspp = 16\nlayers = [\"color\", \"standard_error\"]\nmax_bounces = " +
                                 std::to_string(bounces) + "\n";
        for (const double color : render_scene(furnace(flat, 0.75, film)).color) EXPECT_NEAR(color, expected, 1e-5);
        for (const double color : render_scene(furnace(flat, 0.75, film, glass)).color)
            EXPECT_LT(color, expected * (1 + 1e-5));
    }
}

/// A floor at z = 0 of albedo 0.6, seen from above, and a lamp of radius 0.2 at height 1 that emits 10.
std::string floor_and_lamp(const std::string& space, const std::string& film) {
    return "[space]\n" + space +
           "[camera]\ntype = \"orthographic\"\nposition = [1.2, 0, 3]\nlook_at = [1.2, 0, 0]\nup = [0, 1, 0]\n"
           "height = 1.6\n[film]\n" +
           film +
           "[[object]]\nname = \"floor\"\nshape = \"rectangle\"\norigin = [-50, -50, 0]\nedge_u = [100, 0, 0]\n"
           "edge_v = [0, 100, 0]\ncolor = [0.6, 0.6, 0.6]\nmaterial = \"diffuse\"\n"
           "[[object]]\nname = \"lamp\"\nshape = \"sphere\"\ncenter = [0, 0, 1]\nradius = 0.2\n"
           "color = [0.5, 0.5, 0.5]\nmaterial = \"diffuse\"\nemission_strength = 20\n";
}

/// Returns the light of pixel i of n × n pixels: the irradiance of a sphere that is wholly above the horizon is
/// π L sin²α cos θ, where sin α is its radius divided by its distance, and θ the angle of its centre from the normal.
double light_of_floor(std::size_t i, std::size_t n) {
    const double x = 1.2 + 1.6 * ((double(i % n) + 0.5) / double(n) - 0.5),
                 y = 1.6 * ((double(i / n) + 0.5) / double(n) - 0.5), square = x * x + y * y + 1;
    return 0.6 * 10 * 0.04 / (square * std::sqrt(square));
}

TEST(Diffuse, LightsAFloorAsInTheClosedForm) {
    constexpr std::size_t n = 24;
    // The second space is a black hole so small that it bends nothing. Its rest frames and null rays are used.
    for (const std::string& space : {flat, std::string("hamiltonian = \"schwarzschild\"\nrg = 1e-6\n"
                                                       "center = [0, 0, -30]\n")}) {
        const Rendered picture = render_scene(
            floor_and_lamp(space,
                           "size = [24, 24]\nspp = 256\nmax_bounces = 1\nlayers = [\"color\", \"standard_error\"]\n"));
        double sum = 0, expected = 0, chi = 0;
        for (std::size_t i = 0; i < n * n; ++i) {
            const double light = light_of_floor(i, n);
            sum += picture.color[3 * i];
            expected += light;
            chi += std::pow((picture.color[3 * i] - light) / picture.error[3 * i], 2);
        }
        const double error = error_of_mean(picture) * n * n;
        EXPECT_LT(error, 0.0017 * expected);
        EXPECT_NEAR(sum, expected, std::min(3 * error, 0.005 * expected)) << space;
        EXPECT_LT(std::sqrt(chi / (n * n)), 1.4);  // 1.08 for Student's t with 15 degrees of freedom
    }
}

// The spread of the pixels over 64 seeds is the standard error. Its own relative error is 1/√126 = 9 %.
TEST(Diffuse, HasTheStandardErrorOfManySeeds) {
    constexpr int seeds = 64;
    constexpr std::size_t n = 12;
    std::vector<double> sum(n * n), squares(n * n), predicted(n * n);
    for (int seed = 0; seed < seeds; ++seed) {
        const Rendered picture = render_scene(
            floor_and_lamp(flat,
                           "size = [12, 12]\nspp = 64\nmax_bounces = 1\nlayers = [\"color\", \"standard_error\"]\n"),
            {"film.seed=" + std::to_string(seed)});
        for (std::size_t i = 0; i < n * n; ++i) {
            sum[i] += picture.color[3 * i] / seeds;
            squares[i] += picture.color[3 * i] * picture.color[3 * i] / seeds;
            predicted[i] += picture.error[3 * i] * picture.error[3 * i] / seeds;
        }
    }
    std::size_t within = 0;
    for (std::size_t i = 0; i < n * n; ++i) {
        const double spread = std::sqrt((squares[i] - sum[i] * sum[i]) * seeds / (seeds - 1));
        within += std::abs(spread / std::sqrt(predicted[i]) - 1) < 0.2;
    }
    EXPECT_GE(double(within), 0.95 * n * n);
}

// A sky with a small sun lights a floor: irradiance of the sun and of the even rest of the sky.
TEST(Diffuse, IsLitByABrightSpotOfTheSky) {
    constexpr int width = 64, height = 32;
    const auto path = std::filesystem::temp_directory_path() / ("kagero-sun-" + std::to_string(::getpid()) + ".pfm");
    std::ofstream file(path, std::ios::binary);
    file << "PF\n" << width << ' ' << height << "\n-1.0\n";
    constexpr int sun_row = 28, sun_column = 20;  // rows of PFM files begin at the bottom
    for (int row = 0; row < height; ++row)
        for (int column = 0; column < width; ++column) {
            const float value = row == sun_row && column == sun_column ? 5000.0f : 1.0f;
            for (int k = 0; k < 3; ++k) file.write(reinterpret_cast<const char*>(&value), sizeof value);
        }
    file.close();
    const std::string scene =
        "[space]\n" + flat + "[sky]\ntexture = \"" + path.string() +
        "\"\n[camera]\nposition = [0, 0, 3]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\nfov = 5\n"
        "[film]\nsize = [16, 16]\nspp = 256\nmax_bounces = 1\nlayers = [\"color\", \"standard_error\"]\n"
        "[[object]]\nname = \"floor\"\nshape = \"rectangle\"\norigin = [-5, -5, 0]\nedge_u = [10, 0, 0]\n"
        "edge_v = [0, 10, 0]\ncolor = [0.5, 0.5, 0.5]\nmaterial = \"diffuse\"\n";
    const Rendered picture = render_scene(scene);
    std::filesystem::remove(path);
    // The texture is interpolated bilinearly: the sun is a pyramid over 2 × 2 texels. Its irradiance is a sum over
    // small cells of solid angle, with the sine of the latitude as the cosine at the floor.
    constexpr double pi = 3.14159265358979323846, texel = pi / height;
    double irradiance = pi;
    constexpr int cells = 400;
    for (int i = 0; i < cells; ++i) {
        const double offset = 2 * (i + 0.5) / cells - 1, latitude = (sun_row + 0.5 + offset) * texel - pi / 2;
        irradiance += 4999 * (1 - std::abs(offset)) * std::sin(latitude) * std::cos(latitude) * texel * (2.0 / cells) *
                      texel;  // the mean of the pyramid along the row is one texel
    }
    const double expected = 0.5 / pi * irradiance, error = error_of_mean(picture);
    // With the cosine distribution alone, the error is 3.5 %: only one ray of 500 meets the sun.
    EXPECT_LT(error, 0.012 * expected);
    EXPECT_NEAR(mean_of(picture.color), expected, 3 * error);
}

// The picture depends on neither threads nor tiles.
TEST(Diffuse, IsTheSameForAnyThreads) {
    const std::string scene = floor_and_lamp(flat, "size = [20, 20]\nspp = 8\n");
    std::vector<std::vector<float>> pictures;
    for (const unsigned threads : {1u, 3u}) {
        Options options;
        options.threads = threads;
        const auto plan = plan_of_text(scene, {}, options);
        Film film = film_of(*plan);
        render(*plan, film);
        pictures.push_back(film.take_plane("color"));
    }
    EXPECT_EQ(pictures[0], pictures[1]);
}

// Single rays end at a diffuse surface, because no branch is the stronger one.
TEST(Diffuse, EndsSingleRays) {
    Options options;
    options.bounces = 5;
    const auto plan = plan_of_text(floor_and_lamp(flat, "size = [4, 4]\n"), {}, options, false);
    std::vector<RayEnd> ends;
    trace(*plan, start_rays(*plan, {{{2, 0, 1}, {0, 0, -1}}}), ends);
    EXPECT_EQ(ends[0].status, Status::hit);
    EXPECT_NEAR(ends[0].q[2], 0, 1e-14);
}

}  // namespace
}  // namespace kagero::test
