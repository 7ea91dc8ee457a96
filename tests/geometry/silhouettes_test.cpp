// Tests rays that pass the silhouette of a closed convex mesh at 1e-9 of its size, outside and inside. The rays are
// parabolas in closed form (hamiltonians/gradient.h), so their distance from the mesh does not depend on the
// integrator. With KAGERO_RAYS=N, each test traces N rays; with KAGERO_FIRST_RAY=K, it begins with ray K of the same
// sequence.
#include "tests/support/closed_meshes.h"
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

namespace kagero::test {
namespace {

/// The rays are bent less than the meshes: a ray that passes one edge on the outside passes the whole mesh.
constexpr double gradient = 0.05, distance_from_edge = 4e-9;
/// A length above the greatest distance of chords from the paths of rays, 1e-5 of the size of the scene.
constexpr double above_chord_tolerance = 2e-4;

int environment_number(const char* name, int otherwise) {
    const char* wanted = std::getenv(name);
    return wanted ? std::atoi(wanted) : otherwise;
}

/// An edge of a closed mesh, and the outward normals of its two triangles.
struct Edge {
    Double3 from, to, normals[2];
};

std::vector<Edge> edges_of(const ClosedMesh& mesh) {
    std::map<std::pair<std::size_t, std::size_t>, std::vector<Double3>> normals;
    for (const auto& triangle : mesh.triangles) {
        const Double3 &a = mesh.corners[triangle[0]], &b = mesh.corners[triangle[1]], &c = mesh.corners[triangle[2]];
        const Double3 normal = unit(cross(subtract(b, a), subtract(c, a)));
        for (std::size_t k = 0; k < 3; ++k)
            normals[std::minmax(triangle[k], triangle[(k + 1) % 3])].push_back(
                scaled(normal, dot(normal, a) < 0 ? -1 : 1));
    }
    std::vector<Edge> edges;
    for (const auto& [ends, of_edge] : normals)
        if (of_edge.size() == 2 && dot(of_edge[0], of_edge[1]) < 0.9995)
            edges.push_back({mesh.corners[ends.first], mesh.corners[ends.second], {of_edge[0], of_edge[1]}});
    return edges;
}

class Silhouettes : public testing::TestWithParam<const char*> {
protected:
    /// Returns the ends of rays that pass the silhouette of the mesh at the given height over its edges.
    /// With `only_above`, edges whose outward direction points downward are left out.
    std::vector<RayEnd> ends_at(const ClosedMesh& mesh, double height, bool only_above = false) {
        const auto path =
            std::filesystem::temp_directory_path() / ("kagero-silhouettes-" + std::to_string(::getpid()) + ".obj");
        std::ofstream(path) << mesh.obj();
        const auto plan = plan_of_text(
            "[space]\nhamiltonian = \"gradient\"\nn0 = 1\ng = " + std::to_string(gradient) +
                "\n[integrator]\nescape_radius = 4\n[camera]\nposition = [3.5, 0, 0]\nlook_at = [0, 0, 0]\n"
                "up = [0, 0, 1]\n[film]\nsize = [4, 4]\n[[object]]\nname = \"thing\"\nshape = \"mesh\"\nfile = \"" +
                path.string() + "\"\n",
            {}, with_strategy(GetParam()), false);
        std::filesystem::remove(path);
        std::vector<Edge> edges = edges_of(mesh);
        if (only_above)
            std::erase_if(edges, [](const Edge& edge) { return edge.normals[0][2] + edge.normals[1][2] < 0.1; });
        const int first = environment_number("KAGERO_FIRST_RAY", 0), count = environment_number("KAGERO_RAYS", 20000);
        std::vector<RayInput> rays;
        for (int i = 0; i < first + count; ++i) {
            const RayInput ray = ray_past(edges[random_() % edges.size()], height);
            if (i >= first) rays.push_back(ray);
        }
        std::vector<RayEnd> ends;
        trace(*plan, start_rays(*plan, rays), ends);
        return ends;
    }
    /// Returns the start of a ray whose path passes a point at `height` over the edge, parallel to the plane between
    /// its triangles.
    RayInput ray_past(const Edge& edge, double height) {
        std::uniform_real_distribution<double> fraction(0.1, 0.9), turn(-1, 1);
        const Double3 along = subtract(edge.to, edge.from), outward = unit(add(edge.normals[0], edge.normals[1]));
        const Double3 across = unit(cross(along, outward));
        const double angle = turn(random_), sign = random_() % 2 ? 1 : -1;
        const Double3 direction = add(scaled(across, sign * std::cos(angle)), scaled(unit(along), std::sin(angle)));
        const Double3 point = add(add(edge.from, scaled(along, fraction(random_))), scaled(outward, height));
        // With dq/dλ = p and dp/dλ = −g/2 ẑ: the position and momentum at −λ.
        const double back = 1 + 0.5 * turn(random_);
        const Double3 p = scaled(unit(direction), std::sqrt(1 - gradient * point[2]));
        const Double3 start = subtract(point, scaled(p, back));
        return {{start[0], start[1], start[2] - gradient * back * back / 4}, {p[0], p[1], p[2] + gradient * back / 2}};
    }

    std::mt19937 random_{29};
};

TEST_P(Silhouettes, RaysOutsideDoNotHit) {
    for (const ClosedMesh& mesh : {ball_mesh(2), box_mesh({1.5, 1.2, 1})}) {
        const std::vector<RayEnd> ends = ends_at(mesh, distance_from_edge);
        for (std::size_t i = 0; i < ends.size(); ++i) ASSERT_EQ(ends[i].status, Status::escaped) << i;
    }
}

// Rays are bent downward. Above the mesh, the chords of a ray therefore lie deeper than its path, and hit the mesh if
// the path does.
TEST_P(Silhouettes, RaysInsideHit) {
    for (const ClosedMesh& mesh : {ball_mesh(2), box_mesh({1.5, 1.2, 1})}) {
        const std::vector<RayEnd> ends = ends_at(mesh, -distance_from_edge, true);
        for (std::size_t i = 0; i < ends.size(); ++i) ASSERT_EQ(ends[i].status, Status::hit) << i;
    }
}

// Below the mesh, a path that is bent into it may enter it by less than the distance from its chord. Such hits are not
// found, but deeper ones are.
TEST_P(Silhouettes, RaysDeeperThanTheChordToleranceHit) {
    for (const ClosedMesh& mesh : {ball_mesh(2), box_mesh({1.5, 1.2, 1})}) {
        const std::vector<RayEnd> ends = ends_at(mesh, -above_chord_tolerance);
        for (std::size_t i = 0; i < ends.size(); ++i) ASSERT_EQ(ends[i].status, Status::hit) << i;
    }
}

INSTANTIATE_TEST_SUITE_P(Strategies, Silhouettes, testing::Values("scalar", "packet"));

}  // namespace
}  // namespace kagero::test
