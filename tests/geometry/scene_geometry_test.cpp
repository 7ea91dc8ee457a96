// Tests of surfaces: colours, orientation of textures, and the clearance grid.
#include "kernels/intersection/clearance.h"
#include "geometry/clearance/clearance.h"
#include "appearance/paints.h"
#include "geometry/geometry.h"
#include "film/read_image.h"
#include "tests/support/scene_fixture.h"

#include <algorithm>
#include <numbers>
#include <random>

namespace kagero::test {
namespace {

const std::string head =
    "space.hamiltonian = \"flat\"\nfilm.size = [8, 8]\ncamera = { position = [0, -3, 0], look_at = [0, 0, 0], "
    "up = [0, 0, 1] }\n";

/// Image of 2 × 2 pixels: red and green above blue and white.
const char* const four_colors = "P3\n2 2\n255\n255 0 0  0 255 0\n0 0 255  255 255 255\n";

bool close(const Float3& color, const Float3& expected) {
    return std::equal(color.begin(), color.end(), expected.begin(),
                      [](float a, float b) { return std::abs(a - b) <= 1e-6f; });
}

constexpr Float3 red{1, 0, 0}, green{0, 1, 0}, blue{0, 0, 1}, white{1, 1, 1};

/// Returns the distance from q to the nearest face of the cube [−half, half]³, which contains q.
double distance_to_faces(const Double3& q, double half) {
    double distance = std::numeric_limits<double>::infinity();
    for (const double c : q) distance = std::min({distance, half - c, half + c});
    return distance;
}

}  // namespace

using SceneSurfaces = SceneTest;

/// Geometry and paints of a scene.
struct LoadedScene {
    explicit LoadedScene(const SceneDescription& scene) : geometry(scene), paints(scene, geometry, true) {}
    const SceneGeometry geometry;
    const Paints paints;
};

TEST_F(SceneSurfaces, AreAbsentWithoutObjects) {
    const SceneGeometry geometry(load(head));
    EXPECT_EQ(geometry.kernel_view(), nullptr);
    EXPECT_EQ(geometry.diagonal(), 0);
}

TEST_F(SceneSurfaces, HaveTheStatedNumberOfSquaresAlongTheirEdges) {
    const LoadedScene loaded(load(head + "[[object]]\nshape = \"rectangle\"\norigin = [-1, 0, 0]\nedge_u = [2, 0, 0]\n"
                                             "edge_v = [0, 0, 1]\nchecker = [4, 2]\ncolor = [1, 1, 1]\n"));
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 2; ++j) {
            const float expected = (i + j) % 2 == 0 ? 1.0f : 0.25f;
            // Both triangles use the texture coordinates of the whole rectangle.
            for (const std::uint32_t triangle : {0u, 1u}) {
                const Float3 color =
                    loaded.paints.surface_color(0, triangle, {-1 + (i + 0.5) / 2, 0, (j + 0.5) / 2}, {0, 1, 0});
                EXPECT_EQ(color, (Float3{expected, expected, expected})) << i << ' ' << j;
            }
        }
}

// The image is upright and not mirrored, seen from inside a room and from outside a box.
TEST_F(SceneSurfaces, ShowImagesUprightOnWalls) {
    write("four.ppm", four_colors);
    for (const std::string shape : {"room", "box"}) {
        const LoadedScene loaded(load(head + "space.center = [5, 5, 5]\n[[object]]\nshape = \"" + shape +
                                          "\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]\ntexture = \"four.ppm\"\n"));
        for (std::uint32_t face = 0; face < 6; ++face) {
            Double3 outward{}, up{};
            outward[face / 2] = face % 2 == 0 ? 1 : -1;
            up[face / 2 == 2 ? 1 : 2] = 1;
            const double sign = shape == "room" ? 1 : -1;
            const Double3 forward = scaled(outward, sign), right = cross(forward, up);
            const auto at = [&](double x, double y) {
                const Double3 point = add(outward, add(scaled(right, x), scaled(up, y)));
                return loaded.paints.surface_color(0, 2 * face + (x > y ? 0 : 1), subtract(point, {5, 5, 5}), forward);
            };
            EXPECT_TRUE(close(at(-0.5, 0.5), red)) << shape << face;
            EXPECT_TRUE(close(at(0.5, 0.5), green)) << shape << face;
            EXPECT_TRUE(close(at(-0.5, -0.5), blue)) << shape << face;
            EXPECT_TRUE(close(at(0.5, -0.5), white)) << shape << face;
            // At the edges, colours of the opposite edges must not be mixed in.
            EXPECT_TRUE(close(at(-0.99, 0.99), red)) << shape << face;
            EXPECT_TRUE(close(at(0.99, -0.99), white)) << shape << face;
        }
    }
}

TEST_F(SceneSurfaces, HaveASkyWithLongitude0InTheMiddleAndEastOnTheLeft) {
    write("four.ppm", four_colors);
    const auto direction = [](double longitude, double latitude) {
        const double degree = std::numbers::pi / 180;
        return Double3{std::cos(latitude * degree) * std::cos(longitude * degree),
                       std::cos(latitude * degree) * std::sin(longitude * degree), std::sin(latitude * degree)};
    };
    const LoadedScene loaded(load(head + "sky.texture = \"four.ppm\"\n"));
    EXPECT_TRUE(close(loaded.paints.sky_color(direction(90, 45)), red));     // north-east: upper left
    EXPECT_TRUE(close(loaded.paints.sky_color(direction(-90, 45)), green));  // north-west: upper right
    EXPECT_TRUE(close(loaded.paints.sky_color(direction(90, -45)), blue));
    // This direction is below the middle of the last row, so that the row is not interpolated.
    EXPECT_TRUE(close(loaded.paints.sky_color(direction(-90, -80)), white));
    EXPECT_EQ(sky_coordinates({1, 0, 0}, Double3{0, 0, 1}), (std::array<double, 2>{0.5, 0.5}));
    for (const Double3& pole :
         {Double3{0, 0, 2}, Double3{0, 3, 0}, Double3{1, 0, 0}, Double3{-1, 0, 0}, Double3{1, 2, 3}}) {
        EXPECT_NEAR(sky_coordinates(unit(pole), pole)[1], 1, 1e-7);
        const Double3 side = unit(cross(pole, {0.3, -0.5, 0.7}));
        EXPECT_NEAR(sky_coordinates(side, pole)[1], 0.5, 1e-15);
    }
}

TEST_F(SceneSurfaces, HaveEquirectangularImagesOnSpheres) {
    write("four.ppm", four_colors);
    const LoadedScene loaded(load(head + "[[object]]\nshape = \"sphere\"\ncenter = [1, 2, 3]\nradius = 2\n"
                                             "texture = \"four.ppm\"\nshading = \"lambert\"\n"));
    const double s = std::sqrt(2.0);
    const float light = static_cast<float>(1 / s);
    // The west is on the left, seen from outside.
    EXPECT_TRUE(close(loaded.paints.surface_color(0, 0, {1, 2 - s, 3 + s}, {0, 1, 0}), {light, 0, 0}));
    EXPECT_TRUE(close(loaded.paints.surface_color(0, 0, {1, 2 + s, 3 + s}, {0, -1, 0}), {0, light, 0}));
    const double high = std::sqrt(4 - 0.04 * 0.04);
    // Near the north pole, no colour of the south pole is mixed in.
    EXPECT_TRUE(close(loaded.paints.surface_color(0, 0, {1, 2 - 0.04, 3 + high}, {0, 0, -1}),
                      {static_cast<float>(high / 2), 0, 0}));
}

// The factor is a power of two, so that the scaling causes no rounding.
TEST_F(SceneSurfaces, AreScaledToOrderOneByAPowerOfTwo) {
    const SceneGeometry geometry(
        load(head + "space.center = [100, 0, 0]\n[[object]]\nshape = \"sphere\"\ncenter = [100, 0, 0]\n"
                    "radius = 300\n"));
    const Geometry* view = geometry.kernel_view();
    ASSERT_NE(view, nullptr);
    EXPECT_EQ(view->scale, 1.0 / 512);
    EXPECT_EQ(view->shift[0], 0);
    EXPECT_EQ(view->surfaces[0].center[0], 0);
}

TEST_F(SceneSurfaces, AreRefusedIfTheyAreTooSmallForFloat) {
    const std::string tiny = "[[object]]\nshape = \"sphere\"\ncenter = [1, 0, 0]\nradius = 1e-20\n";
    EXPECT_THROW(SceneGeometry(load(head + tiny)), InputError);
}

ClearBox<double> box_at(const ClearanceGrid& grid, const Double3& q) {
    ClearBox<double> box;
    box.update(grid, {q[0], q[1], q[2]}, 1);
    return box;
}

/// Returns the least and the greatest distance from c to the points of a box.
std::array<double, 2> distances_to(const ClearBox<double>& box, const Double3& c) {
    const double lower[3] = {box.lower.x, box.lower.y, box.lower.z}, upper[3] = {box.upper.x, box.upper.y, box.upper.z};
    double nearest2 = 0, farthest2 = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double near = std::max({lower[k] - c[k], c[k] - upper[k], 0.0}),
                     far = std::max(c[k] - lower[k], upper[k] - c[k]);
        nearest2 += near * near;
        farthest2 += far * far;
    }
    return {std::sqrt(nearest2), std::sqrt(farthest2)};
}

/// Returns true if the box contains the cube around q whose edges have the length 2 half.
bool contains_cube(const ClearBox<double>& box, const Double3& q, double half) {
    return to_bits(box.contains(
               {{q[0] - half, q[1] - half, q[2] - half}, {q[0] + half, q[1] + half, q[2] + half}})) != 0;
}

TEST_F(SceneSurfaces, CauseARemarkIfTheyAreTooSmallForTheirDistance) {
    const auto remarks_with = [&](const char* distance) -> std::vector<std::string> {
        return SceneGeometry(load(head +
                                  "[[object]]\nname = \"sun\"\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 100\n"
                                  "[[object]]\nname = \"planet\"\nshape = \"sphere\"\ncenter = [" +
                                  std::string(distance) + ", 0, 0]\nradius = 1\n"))
            .remarks();
    };
    EXPECT_TRUE(remarks_with("10000").empty());
    const auto remarks = remarks_with("1000000");
    ASSERT_EQ(remarks.size(), 1u);
    EXPECT_EQ(remarks[0].find("object planet: Embree's single precision displaces it"), 0u) << remarks[0];
}

// The surfaces are a cube and a sphere within it, so that the distance d from q to the surfaces is known. A clear box
// must contain no surface. It must contain the cube around q with edges of 2 (d/√3 − 1.5 c), where c is the cell size.
TEST_F(SceneSurfaces, AreInNoClearBox) {
    const SceneGeometry geometry(
        load(head + "space.center = [0.5, 0, 0]\n[[object]]\nshape = \"room\"\nmin = [-0.5, -1, -1]\n"
                    "max = [1.5, 1, 1]\n[[object]]\nshape = \"sphere\"\ncenter = [0.7, 0.3, 0]\nradius = 0.2\n"));
    const Geometry* view = geometry.kernel_view();
    ASSERT_NE(view->clearance, nullptr);
    const ClearanceGrid& grid = *view->clearance;
    std::mt19937 random(1);
    std::uniform_real_distribution<double> coordinate(-1.5, 1.5);
    EXPECT_TRUE(grid.cell[0] == grid.cell[1] && grid.cell[0] == grid.cell[2]);
    for (int i = 0; i < 20000; ++i) {
        const Double3 q{coordinate(random), coordinate(random), coordinate(random)};
        const ClearBox<double> box = box_at(grid, q);
        if (!contains_cube(box, q, 0)) continue;  // near a surface, the box can be empty
        const bool in_room = std::abs(q[0]) < 1 && std::abs(q[1]) < 1 && std::abs(q[2]) < 1;
        const bool stays_in_room = box.lower.x > -1 && box.lower.y > -1 && box.lower.z > -1 && box.upper.x < 1 &&
                                   box.upper.y < 1 && box.upper.z < 1;
        const bool stays_out = box.lower.x > 1 || box.lower.y > 1 || box.lower.z > 1 || box.upper.x < -1 ||
                               box.upper.y < -1 || box.upper.z < -1;
        ASSERT_TRUE(in_room ? stays_in_room : stays_out) << q[0] << ' ' << q[1] << ' ' << q[2];
        const auto [nearest, farthest] = distances_to(box, {0.2, 0.3, 0});
        ASSERT_TRUE(nearest > 0.2 || farthest < 0.2) << q[0] << ' ' << q[1] << ' ' << q[2];
    }
    int close_to_walls = 0;
    for (int i = 0; i < 20000; ++i) {
        const Double3 q{coordinate(random) / 1.5, coordinate(random) / 1.5, coordinate(random) / 1.5};
        const double ball_distance = std::abs(length(subtract(q, {0.2, 0.3, 0})) - 0.2),
                     distance = std::min(ball_distance, distance_to_faces(q, 1));
        const ClearBox<double> box = box_at(grid, q);
        const double half_edge = distance / std::sqrt(3.0) - 1.5 * grid.cell[0];
        ASSERT_TRUE(half_edge <= 0 || contains_cube(box, q, half_edge)) << q[0] << ' ' << q[1] << ' ' << q[2];
        // A box can extend closer than a cell to a plane that is perpendicular to a coordinate axis.
        if (ball_distance > 0.3)
            close_to_walls += box.upper.x > 0.99 || box.lower.x < -0.99 || box.upper.y > 0.99 || box.lower.y < -0.99;
    }
    EXPECT_GT(close_to_walls, 5000);
    for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_LT(grid.origin[k], -1);
        EXPECT_GT(grid.origin[k] + grid.cells[k] * grid.cell[k], 1);
    }
}

// Between a wide floor and a wide ceiling, clear boxes must extend from the floor to the ceiling and far to the sides.
TEST_F(SceneSurfaces, LeaveWideClearBoxesInAFlatScene) {
    const SceneGeometry geometry(
        load(head +
             "[[object]]\nshape = \"rectangle\"\norigin = [-50, -40, -1]\nedge_u = [100, 0, 0]\nedge_v = [0, 80, 0]\n"
             "[[object]]\nshape = \"rectangle\"\norigin = [-50, -40, 1]\nedge_u = [100, 0, 0]\nedge_v = [0, 80, 0]\n"
             "[[object]]\nshape = \"sphere\"\ncenter = [10, 5, 0]\nradius = 0.5\n"));
    const ClearanceGrid& grid = *geometry.kernel_view()->clearance;
    EXPECT_EQ(grid.cell[0], grid.cell[1]);
    EXPECT_NEAR(grid.cell[0] / grid.cell[2], 25, 1e-9);
    EXPECT_GE(2 * grid.cells[2], grid.cells[0]);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> coordinate(-0.9, 0.9);
    int wide = 0;
    for (int i = 0; i < 20000; ++i) {
        const Double3 q{50 * coordinate(random), 40 * coordinate(random), coordinate(random)};
        const ClearBox<double> box = box_at(grid, q);
        if (!contains_cube(box, q, 0)) continue;
        ASSERT_TRUE(box.lower.z > -1 && box.upper.z < 1);
        ASSERT_GT(distances_to(box, {10, 5, 0})[0], 0.5);
        wide += box.lower.z < -0.99 && box.upper.z > 0.99 &&
                std::min(box.upper.x - box.lower.x, box.upper.y - box.lower.y) > 20;
    }
    EXPECT_GT(wide, 19000);
}

/// Returns an OBJ file with random vertices. Triangle n consists of the vertices n·step, n·step + 1 and n·step + 2.
std::string random_mesh(std::mt19937& random, int vertices, int step) {
    std::uniform_real_distribution<double> coordinate(-1, 1);
    std::string text;
    for (int i = 0; i < vertices; ++i) {
        text += 'v';
        for (int k = 0; k < 3; ++k) text += ' ' + std::to_string(coordinate(random));
        text += '\n';
    }
    for (int i = 1; i <= vertices - 2; i += step)
        text += "f " + std::to_string(i) + ' ' + std::to_string(i + 1) + ' ' + std::to_string(i + 2) + '\n';
    return text;
}

/// Returns the point of a triangle with the barycentric coordinates a, b and c.
Double3 triangle_point(const Surface& surface, std::uint32_t triangle, double a, double b, double c) {
    const auto corner = [&](std::uint32_t k) {
        const double* v = surface.vertices + 3 * surface.triangles[3 * triangle + k];
        return Double3{v[0], v[1], v[2]};
    };
    return add(scaled(corner(0), a), add(scaled(corner(1), b), scaled(corner(2), c)));
}

// Clear boxes are compared with random points on the triangles.
TEST_F(SceneSurfaces, AreInNoClearBoxOfARandomMesh) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> coordinate(-1, 1), share(0, 1);
    write("mesh.obj", random_mesh(random, 90, 3));
    const SceneGeometry geometry(load(head + "[[object]]\nshape = \"mesh\"\nfile = \"mesh.obj\"\n"));
    const Geometry& view = *geometry.kernel_view();
    const ClearanceGrid& grid = *view.clearance;
    std::vector<Double3> on_surface;
    for (std::uint32_t t = 0; t < 30; ++t)
        for (int i = 0; i < 300; ++i) {
            double a = share(random), b = share(random);
            if (a + b > 1) {
                a = 1 - a;
                b = 1 - b;
            }
            on_surface.push_back(triangle_point(view.surfaces[0], t, a, b, 1 - a - b));
        }
    int not_empty = 0;
    for (int i = 0; i < 2000; ++i) {
        const Double3 q{coordinate(random), coordinate(random), coordinate(random)};
        const ClearBox<double> box = box_at(grid, q);
        not_empty += contains_cube(box, q, 0);
        for (const Double3& p : on_surface) ASSERT_FALSE(contains_cube(box, p, 0));
    }
    EXPECT_GT(not_empty, 1000);
}

// The result of distance_to_surfaces is compared with the least distance to samples of the triangles. Edges are shorter
// than 3.5, so that a sample is at most 3.5/40 from the nearest point.
TEST_F(SceneSurfaces, HaveTheClearanceOfABruteForceSearch) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> coordinate(-1, 1);
    write("mesh.obj", random_mesh(random, 60, 1));
    const SceneGeometry geometry(load(head + "[[object]]\nshape = \"mesh\"\nfile = \"mesh.obj\"\n"));
    const Geometry& view = *geometry.kernel_view();
    for (int i = 0; i < 50; ++i) {
        const Double3 q{coordinate(random), coordinate(random), coordinate(random)};
        const double nearest = distance_to_surfaces(view, q, std::numeric_limits<double>::infinity());
        double sampled = std::numeric_limits<double>::infinity();
        for (std::uint32_t t = 0; t < 58; ++t)
            for (int a = 0; a <= 40; ++a)
                for (int b = 0; a + b <= 40; ++b) {
                    const Double3 p = triangle_point(view.surfaces[0], t, a / 40.0, b / 40.0, (40 - a - b) / 40.0);
                    sampled = std::min(sampled, length(subtract(p, q)));
                }
        EXPECT_LE(nearest, sampled + 4e-6);  // rounding to float
        EXPECT_GE(nearest, sampled - 3.5 / 40);
    }
}

TEST_F(SceneSurfaces, HaveNoGridWithoutCulling) {
    const SceneGeometry geometry(
        load(head + "integrator.cull = \"none\"\n[[object]]\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\n"));
    EXPECT_EQ(geometry.kernel_view()->clearance, nullptr);
}

// The expected value is ((188/255 + 0.055)/1.055)^2.4. The second read must fail, because the file is removed.
TEST(Texture, DecodesSrgbImages) {
    const std::string path =
        (std::filesystem::temp_directory_path() / ("kagero-gray-" + std::to_string(getpid()) + ".ppm")).string();
    std::ofstream(path) << "P3\n1 1\n255\n188 188 188\n";
    const StoredImage image = read_image(path, {});
    std::filesystem::remove(path);
    EXPECT_NEAR(visit_texels(image, [](const auto& texels) { return texels[0]; }), 0.5029, 1e-4);
    EXPECT_THROW(read_image(path, {}), InputError);
}

}  // namespace kagero::test
