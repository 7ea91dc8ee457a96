// Tests that hits of meshes and spheres do not depend on the rounding of Embree's floats. Closed meshes have no holes
// at corners and edges, and rays that pass a surface at a distance of 1e-9 of its size do not hit it. With
// KAGERO_RAYS=N, each test traces N rays instead of some thousands; with KAGERO_FIRST_RAY=K, it begins with ray K of
// the same sequence.
#include "tests/support/closed_meshes.h"
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace kagero::test {
namespace {

constexpr double radius = 2;
/// An isotropic medium in which rays are bent and run along the same path in both directions.
const char* const lens =
    "hamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - (1 + 0.4*exp(-(x^2 + y^2 + z^2)/4))^2)\"\n";
const char* const flat = "hamiltonian = \"flat\"\n";

/// An object that no ray of the tests meets.
const char* const far_away = "shape = \"sphere\"\nradius = 0.01\ncenter = [7, 0, 0]\n";

int environment_number(const char* name, int otherwise) {
    const char* wanted = std::getenv(name);
    return wanted ? std::atoi(wanted) : otherwise;
}
/// Returns the number of the first ray, which is even.
int first_ray() { return environment_number("KAGERO_FIRST_RAY", 0) / 2 * 2; }
int number_of_rays() { return environment_number("KAGERO_RAYS", 4000); }
/// Returns the number behind that of the last ray.
int end_of_rays() { return first_ray() + number_of_rays(); }

std::string scene_with(const char* space, const std::string& object) {
    return "[space]\n" + std::string(space) +
           "[integrator]\nescape_radius = 8\n[camera]\nposition = [5, 0, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n"
           "[film]\nsize = [4, 4]\n[[object]]\nname = \"thing\"\n" + object;
}

class ExactHits : public testing::TestWithParam<const char*> {
protected:
    /// Returns a plan for lists of rays with the ball as a mesh.
    std::unique_ptr<Plan> plan_with_ball(const char* space) const {
        return plan_with_mesh(space, ball_.obj());
    }
    static std::unique_ptr<Plan> plan_with_mesh(const char* space, const std::string& obj) {
        const auto path =
            std::filesystem::temp_directory_path() / ("kagero-hits-" + std::to_string(::getpid()) + ".obj");
        std::ofstream(path) << obj;
        auto plan = plan_with(space, "shape = \"mesh\"\nfile = \"" + path.string() + "\"\n");
        std::filesystem::remove(path);
        return plan;
    }
    static std::unique_ptr<Plan> plan_with(const char* space, const std::string& object) {
        return plan_of_text(scene_with(space, object), {}, with_strategy(GetParam()), false);
    }
    /// Returns a corner, or a point of an edge, chosen at random.
    Double3 target() {
        const auto& triangle = ball_.triangles[random_() % ball_.triangles.size()];
        const Double3 &a = ball_.corners[triangle[0]], &b = ball_.corners[triangle[1 + random_() % 2]];
        return random_() % 2 ? a : add(a, scaled(subtract(b, a), std::uniform_real_distribution<double>()(random_)));
    }
    Double3 direction() {
        std::normal_distribution<double> normal;
        return unit({normal(random_), normal(random_), normal(random_)});
    }
    static std::vector<RayEnd> ends_of(const Plan& plan, const std::vector<RayInput>& rays) {
        std::vector<RayEnd> ends;
        trace(plan, start_rays(plan, rays), ends);
        return ends;
    }
    static Double3 point_of(const RayEnd& end) { return {end.q[0], end.q[1], end.q[2]}; }

    const ClosedMesh ball_ = ball_mesh(radius);
    std::mt19937 random_{17};
};

TEST_P(ExactHits, StraightRaysDoNotPassCornersAndEdges) {
    const auto plan = plan_with_ball(flat);
    std::vector<RayInput> rays;
    std::vector<Double3> targets;
    for (int i = 0; i < end_of_rays(); ++i) {
        const Double3 to = target();
        const bool is_inside = i % 2;
        const Double3 from = is_inside ? scaled(direction(), 1.2) : add(scaled(unit(to), 5), direction());
        if (i < first_ray()) continue;
        rays.push_back({from, subtract(to, from)});
        targets.push_back(to);
    }
    const std::vector<RayEnd> ends = ends_of(*plan, rays);
    for (std::size_t i = 0; i < ends.size(); ++i) {
        ASSERT_EQ(ends[i].status, Status::hit) << first_ray() + int(i);
        ASSERT_LT(length(subtract(point_of(ends[i]), targets[i])), 1e-12) << first_ray() + int(i);
    }
}

// Each ray is first traced from a point close to the corner or edge, and then back along the same path. The error of
// the path is about 1e-9.
TEST_P(ExactHits, BentRaysDoNotPassCornersAndEdges) {
    const auto plan = plan_with_ball(lens);
    const auto without_ball = plan_with(lens, far_away);
    std::vector<RayInput> outward;
    std::vector<Double3> targets;
    for (int i = 0; i < end_of_rays(); ++i) {
        const Double3 to = target(), along = add(scaled(unit(to), i % 2 ? -1.5 : 1.5), direction());
        if (i < first_ray()) continue;
        targets.push_back(to);
        outward.push_back({to, along});
    }
    without_ball->run.parameter_limit = 1.5;  // inside the ball, the paths are shorter than its diameter
    std::vector<RayInput> back;
    for (const RayEnd& end : ends_of(*without_ball, outward))
        back.push_back({point_of(end), scaled({end.v[0], end.v[1], end.v[2]}, -1)});
    const std::vector<RayEnd> ends = ends_of(*plan, back);
    for (std::size_t i = 0; i < ends.size(); ++i) {
        ASSERT_EQ(ends[i].status, Status::hit) << first_ray() + int(i);
        ASSERT_LT(length(subtract(point_of(ends[i]), targets[i])), 1e-6) << first_ray() + int(i);
    }
}

TEST_P(ExactHits, StraightRaysThatPassATriangleDoNotHitIt) {
    const auto plan = plan_with_mesh(flat, "v -2 -1 0.5\nv 2 -1 0.25\nv 0.5 2 -0.5\nf 1 2 3\n");
    const std::array<Double3, 3> corner{{{-2, -1, 0.5}, {2, -1, 0.25}, {0.5, 2, -0.5}}};
    const Double3 normal = unit(cross(subtract(corner[1], corner[0]), subtract(corner[2], corner[0])));
    std::vector<RayInput> rays;
    for (int i = 0; i < end_of_rays(); ++i) {
        const std::size_t k = random_() % 3;
        const Double3 &a = corner[k], &b = corner[(k + 1) % 3];
        const Double3 outward = unit(cross(subtract(b, a), normal));
        const double fraction = std::uniform_real_distribution<double>(0.1, 0.9)(random_);
        const Double3 on_edge = add(a, scaled(subtract(b, a), fraction));
        Double3 along = direction();
        if (std::abs(dot(along, normal)) < 0.2) along = normal;
        const Double3 to = add(on_edge, scaled(outward, i % 2 ? 4e-9 : -4e-9));
        if (i < first_ray()) continue;
        rays.push_back({subtract(to, scaled(along, 3)), along});
    }
    const std::vector<RayEnd> ends = ends_of(*plan, rays);
    for (std::size_t i = 0; i < ends.size(); ++i)
        ASSERT_EQ(ends[i].status, i % 2 ? Status::escaped : Status::hit) << first_ray() + int(i);
}

TEST_P(ExactHits, StraightRaysThatPassASphereDoNotHitIt) {
    const auto plan = plan_with(flat, "shape = \"sphere\"\nradius = 2\ncenter = [0.3, 0.1, -0.2]\n");
    std::vector<RayInput> rays;
    for (int i = 0; i < end_of_rays(); ++i) {
        const Double3 along = direction(), across = unit(cross(along, direction()));
        if (i < first_ray()) continue;
        const Double3 nearest = add({0.3, 0.1, -0.2}, scaled(across, 2 * (1 + (i % 2 ? 1e-9 : -1e-9))));
        rays.push_back({subtract(nearest, scaled(along, 4)), along});
    }
    const std::vector<RayEnd> ends = ends_of(*plan, rays);
    for (std::size_t i = 0; i < ends.size(); ++i)
        ASSERT_EQ(ends[i].status, i % 2 ? Status::escaped : Status::hit) << first_ray() + int(i);
}

// The medium is symmetric around the centre of the sphere. A ray is traced from the point of its path nearest to the
// centre to the escape sphere, and then back. The conserved angular momentum gives the angle of incidence at a hit.
TEST_P(ExactHits, BentRaysThatPassASphereDoNotHitIt) {
    const auto plan = plan_with(lens, "shape = \"sphere\"\nradius = 1.5\ncenter = [0, 0, 0]\n"),
               without_sphere = plan_with(lens, far_away);
    without_sphere->run.parameter_limit = 3;
    const auto height = [](std::size_t i) { return i % 2 ? 1e-8 : -1e-8; };
    std::vector<RayInput> outward, back;
    for (int i = 0; i < end_of_rays(); ++i) {
        const Double3 along = direction(), across = unit(cross(along, direction()));
        if (i < first_ray()) continue;
        outward.push_back({scaled(across, 1.5 + height(std::size_t(i))), along});
    }
    for (const RayEnd& end : ends_of(*without_sphere, outward))
        back.push_back({point_of(end), scaled({end.v[0], end.v[1], end.v[2]}, -1)});
    const std::vector<RayEnd> ends = ends_of(*plan, back);
    for (std::size_t i = 0; i < ends.size(); ++i) {
        ASSERT_EQ(ends[i].status, i % 2 ? Status::escaped : Status::hit) << first_ray() + int(i);
        if (ends[i].status == Status::hit) {
            EXPECT_NEAR(length(point_of(ends[i])), 1.5, 1e-10);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Strategies, ExactHits, testing::Values("scalar", "packet"));

}  // namespace
}  // namespace kagero::test
