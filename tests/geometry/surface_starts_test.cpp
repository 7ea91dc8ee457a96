// Tests rays that start on surfaces, as reflected rays do. Such a ray leaves its surface, hits every other surface
// however close it is, and never passes through a closed surface. With KAGERO_RAYS=N, each test traces N rays.
#include "tests/support/closed_meshes.h"
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace kagero::test {
namespace {

constexpr int bounces = 20;
/// Spaces with straight rays, with parabolas and with circles.
const char* const spaces[] = {
    "hamiltonian = \"flat\"\n",
    "hamiltonian = \"gradient\"\nn0 = 1\ng = 0.2\n",
    "hamiltonian = \"fisheye\"\nn0 = 2\nradius = 3\n",
};
/// An object that no ray of the tests meets.
const char* const far_away = "shape = \"sphere\"\nradius = 0.01\ncenter = [7, 0, 0]\n";

int number_of_rays() {
    const char* wanted = std::getenv("KAGERO_RAYS");
    return wanted ? std::atoi(wanted) : 3000;
}

struct Case {
    const char* strategy;
    int space;
};

class SurfaceStarts : public testing::TestWithParam<Case> {
protected:
    /// Returns a plan for lists of rays; each object is the text of an [[object]].
    std::unique_ptr<Plan> plan_with(const std::vector<std::string>& objects) const {
        std::string scene = "[space]\n" + std::string(spaces[GetParam().space]) +
                            "[integrator]\nescape_radius = 8\n[camera]\nposition = [5, 0, 0]\nlook_at = [0, 0, 0]\n"
                            "up = [0, 0, 1]\n[film]\nsize = [4, 4]\n";
        for (std::size_t i = 0; i < objects.size(); ++i)
            scene += "[[object]]\nname = \"object" + std::to_string(i) + "\"\n" + objects[i];
        return plan_of_text(scene, {}, with_strategy(GetParam().strategy), false);
    }
    std::unique_ptr<Plan> plan_with_mesh(const std::string& obj) const {
        const auto path =
            std::filesystem::temp_directory_path() / ("kagero-starts-" + std::to_string(::getpid()) + ".obj");
        std::ofstream(path) << obj;
        auto plan = plan_with({"shape = \"mesh\"\nfile = \"" + path.string() + "\"\n"});
        std::filesystem::remove(path);
        return plan;
    }
    static std::vector<RayEnd> ends_of(const Plan& plan, const std::vector<RayStart>& starts) {
        std::vector<RayEnd> ends;
        trace(plan, starts, ends);
        return ends;
    }
    static Double3 point_of(const RayEnd& end) { return {end.q[0], end.q[1], end.q[2]}; }
    static Double3 velocity_of(const RayEnd& end) { return {end.v[0], end.v[1], end.v[2]}; }
    double uniform(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random_); }
    Double3 direction() {
        std::normal_distribution<double> normal;
        return unit({normal(random_), normal(random_), normal(random_)});
    }
    /// Returns rays that meet the targets within about 1e-9: straight rays exactly, bent rays by tracing the path
    /// back. `backward(i)` is the direction in which ray i leaves its target when it is traced back.
    std::vector<RayInput> aimed_at(const std::vector<Double3>& targets, const std::vector<Double3>& backward,
                                   double distance) const {
        std::vector<RayInput> away, rays;
        for (std::size_t i = 0; i < targets.size(); ++i) away.push_back({targets[i], backward[i]});
        const auto empty = plan_with({far_away});
        empty->run.parameter_limit = distance;
        for (const RayEnd& end : ends_of(*empty, start_rays(*empty, away)))
            rays.push_back({point_of(end), scaled(velocity_of(end), -1)});
        return rays;
    }

    std::mt19937 random_{23};
};

/// A closed body whose inner side reflects.
class Body {
public:
    explicit Body(ClosedMesh mesh) : mesh_(std::move(mesh)) {}
    explicit Body(double radius) : radius_(radius) {}

    bool is_sphere() const { return mesh_.triangles.empty(); }
    const ClosedMesh& mesh() const { return mesh_; }
    /// Returns the unit normal at a point of the surface, toward the inside. All bodies are convex and contain the
    /// origin.
    Double3 normal(std::uint32_t primitive, const Double3& q) const {
        if (is_sphere()) return scaled(unit(q), -1);
        const auto [a, b, c] = corners_of(primitive);
        const Double3 n = unit(cross(subtract(b, a), subtract(c, a)));
        return dot(n, a) > 0 ? scaled(n, -1) : n;
    }
    /// Returns the height of a point over the triangle or sphere, positive inside.
    double height(std::uint32_t primitive, const Double3& q) const {
        if (is_sphere()) return radius_ - length(q);
        return dot(normal(primitive, q), subtract(q, corners_of(primitive)[0]));
    }
    /// Returns the greatest distance by which a point of the plane lies beyond an edge of the triangle.
    double distance_beyond_edges(std::uint32_t primitive, const Double3& q) const {
        if (is_sphere()) return 0;
        const auto corners = corners_of(primitive);
        const Double3 n = cross(subtract(corners[1], corners[0]), subtract(corners[2], corners[0]));
        double greatest = -1;
        for (std::size_t k = 0; k < 3; ++k) {
            const Double3 outward = unit(cross(subtract(corners[(k + 1) % 3], corners[k]), n));
            greatest = std::max(greatest, dot(outward, subtract(q, corners[k])));
        }
        return greatest;
    }
    std::array<Double3, 3> corners_of(std::uint32_t primitive) const {
        const auto& triangle = mesh_.triangles[primitive];
        return {mesh_.corners[triangle[0]], mesh_.corners[triangle[1]], mesh_.corners[triangle[2]]};
    }

private:
    ClosedMesh mesh_;
    double radius_ = 0;
};

class ReflectingBodies : public SurfaceStarts {
protected:
    /// Returns a target on the inside of the body: the half of them lie close to edges and corners, at distances from
    /// 1e-17 to 1e-3.
    Double3 target(const Body& body) {
        if (body.is_sphere()) return scaled(direction(), 2);
        const auto primitive = std::uint32_t(random_() % body.mesh().triangles.size());
        const auto [a, b, c] = body.corners_of(primitive);
        const double small = std::pow(10, uniform(-17, -3)), along = random_() % 4 ? uniform(0, 1) : small,
                     across = random_() % 2 ? small : uniform(0, 1 - along);
        return add(a, add(scaled(subtract(b, a), along), scaled(subtract(c, a), across)));
    }
    /// Reflects rays in the body and checks every hit.
    void reflect(const Plan& plan, const Body& body) {
        std::vector<Double3> targets, backward;
        for (int i = 0; i < number_of_rays(); ++i) {
            targets.push_back(target(body));
            backward.push_back(unit(subtract(scaled(direction(), 0.3), targets.back())));
        }
        const std::vector<RayInput> rays = aimed_at(targets, backward, 0.5);
        std::vector<RayStart> starts = start_rays(plan, rays);
        for (int bounce = 0; bounce <= bounces; ++bounce) {
            const std::vector<RayEnd> ends = ends_of(plan, starts);
            std::vector<RayInput> next;
            for (std::size_t i = 0; i < ends.size(); ++i) {
                ASSERT_NO_FATAL_FAILURE(check(body, starts[i], ends[i])) << "ray " << i << " bounce " << bounce;
                const Double3 q = point_of(ends[i]), n = body.normal(ends[i].primitive, q), v = velocity_of(ends[i]);
                next.push_back(
                    {add(q, scaled(n, -body.height(ends[i].primitive, q))), subtract(v, scaled(n, 2 * dot(v, n)))});
            }
            std::vector<RayStart> reflected = start_rays(plan, next);
            for (std::size_t i = 0; i < ends.size(); ++i) {
                reflected[i].surface = ends[i].surface;
                reflected[i].primitive = ends[i].primitive;
            }
            starts = std::move(reflected);
        }
    }
    void check(const Body& body, const RayStart& start, const RayEnd& end) const {
        const auto describe = [&] {
            std::ostringstream text;
            text.precision(17);
            text << "from " << start.q[0] << ' ' << start.q[1] << ' ' << start.q[2] << " along " << start.p[0] << ' '
                 << start.p[1] << ' ' << start.p[2] << " on " << int(start.surface) << ' ' << start.primitive;
            if (start.surface != no_surface) {
                const Double3 q{start.q[0], start.q[1], start.q[2]}, p{start.p[0], start.p[1], start.p[2]};
                text << " beyond edges " << body.distance_beyond_edges(start.primitive, q) << " slope "
                     << dot(p, body.normal(start.primitive, q));
            }
            text << "\nto " << end.q[0] << ' ' << end.q[1] << ' ' << end.q[2] << " on " << end.primitive
                 << " parameter " << end.parameter << " steps " << end.steps;
            return text.str();
        };
        ASSERT_EQ(end.status, Status::hit) << describe();
        const Double3 q = point_of(end), n = body.normal(end.primitive, q);
        ASSERT_NEAR(body.height(end.primitive, q), 0, 1e-11) << describe();
        ASSERT_LT(body.distance_beyond_edges(end.primitive, q), 1e-9) << describe();
        ASSERT_LT(dot(velocity_of(end), n), 1e-9) << describe();
        if (start.surface == no_surface || start.primitive != end.primitive) return;
        // The ray has returned to its surface. The distance follows from the curvature of surface and ray.
        const Double3 from{start.q[0], start.q[1], start.q[2]}, p{start.p[0], start.p[1], start.p[2]};
        const double slope = dot(p, body.normal(end.primitive, from)), travelled = length(subtract(q, from));
        if (!body.is_sphere()) {
            ASSERT_NE(GetParam().space, 0) << describe();
        }
        ASSERT_GT(travelled, slope > 1e-6 ? slope * 0.5 : 0) << describe();
    }
};

TEST_P(ReflectingBodies, BallKeepsItsRays) {
    const Body ball(ball_mesh(2));
    const auto plan = plan_with_mesh(ball.mesh().obj());
    reflect(*plan, ball);
}

TEST_P(ReflectingBodies, BoxKeepsItsRays) {
    const Body box(box_mesh({1.5, 1.2, 1}));
    const auto plan = plan_with_mesh(box.mesh().obj());
    reflect(*plan, box);
}

TEST_P(ReflectingBodies, SphereKeepsItsRays) {
    const Body sphere(2.0);
    const auto plan = plan_with({"shape = \"sphere\"\nradius = 2\ncenter = [0, 0, 0]\n"});
    reflect(*plan, sphere);
}

std::string text_of(const Double3& v) {
    std::ostringstream text;
    text.precision(17);
    text << '[' << v[0] << ", " << v[1] << ", " << v[2] << "]\n";
    return text.str();
}
/// Returns a rectangle with the given normal at a height above the origin.
std::string plate(const Double3& normal, double height) {
    const Double3 u = unit(cross(normal, {0.3, 0.5, 0.8})), v = cross(normal, u);
    const Double3 corner = add(scaled(normal, height), add(scaled(u, -1.6), scaled(v, -1.5)));
    return "shape = \"rectangle\"\norigin = " + text_of(corner) + "edge_u = " + text_of(scaled(u, 3.2)) +
           "edge_v = " + text_of(scaled(v, 3));
}
/// Returns a point of a triangle at the coordinates a and b along its edges.
Double3 point_of_triangle(const Plan& plan, std::uint32_t surface, std::uint32_t primitive, double a, double b) {
    const Surface& mesh = plan.scene->geometry->kernel_view()->surfaces[surface];
    Double3 corner[3];
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t axis = 0; axis < 3; ++axis)
            corner[k][axis] = mesh.vertices[3 * mesh.triangles[3 * primitive + k] + axis];
    return add(corner[0], add(scaled(subtract(corner[1], corner[0]), a), scaled(subtract(corner[2], corner[0]), b)));
}

TEST_P(SurfaceStarts, RaysBetweenClosePlatesHitTheOther) {
    for (const double gap : {1e-6, 1e-9, 1e-10, 1e-11, 1e-12}) {
        const Double3 normal = unit({0.2, -0.4, 0.7});
        const auto plan = plan_with({plate(normal, 0.1), plate(normal, 0.1 + gap)});
        std::vector<RayInput> rays;
        for (int i = 0; i < number_of_rays(); ++i) {
            const Double3 q =
                point_of_triangle(*plan, i & 1, std::uint32_t(i >> 2 & 1), uniform(0.1, 0.4), uniform(0.1, 0.4));
            Double3 d = direction();
            const double rise = dot(d, normal);
            const bool is_upward = i & 2;
            if ((rise > 0) != is_upward) d = subtract(d, scaled(normal, 2 * rise));
            if (std::abs(rise) < 0.5) d = unit(add(d, scaled(normal, is_upward ? 1 : -1)));
            rays.push_back({q, d});
        }
        std::vector<RayStart> starts = start_rays(*plan, rays);
        for (std::size_t i = 0; i < starts.size(); ++i) {
            starts[i].surface = i & 1;
            starts[i].primitive = i >> 2 & 1;
        }
        const std::vector<RayEnd> ends = ends_of(*plan, starts);
        for (std::size_t i = 0; i < ends.size(); ++i) {
            const bool is_between = bool(i & 1) != bool(i & 2);
            const double distance = length(subtract(point_of(ends[i]), rays[i].position));
            if (is_between) {
                ASSERT_EQ(ends[i].status, Status::hit) << i << " gap " << gap;
                ASSERT_EQ(ends[i].surface, i & 1 ? 0u : 1u) << i << " gap " << gap;
                ASSERT_LT(distance, 4 * gap) << i << " gap " << gap;
            } else if (GetParam().space == 0) {
                ASSERT_EQ(ends[i].status, Status::escaped) << i << " gap " << gap;
            } else {
                ASSERT_GT(ends[i].parameter, 0.5) << i << " gap " << gap;  // a bent ray may return to a plate
            }
        }
    }
}

TEST_P(SurfaceStarts, RaysBetweenPlateAndSphereHitTheOther) {
    for (const double gap : {1e-6, 1e-9, 1e-10, 1e-11, 1e-12}) {
        const Double3 normal = unit({0.2, -0.4, 0.7}), center = scaled(normal, 0.1 + gap + 0.5);
        const auto plan =
            plan_with({plate(normal, 0.1), "shape = \"sphere\"\nradius = 0.5\ncenter = " + text_of(center)});
        std::vector<RayInput> rays;
        for (int i = 0; i < number_of_rays(); ++i) {
            Double3 d = direction();
            d = unit(add(d, scaled(normal, (i & 2 ? 1.5 : -1.5))));
            const bool on_sphere = i & 1;
            rays.push_back({scaled(normal, on_sphere ? 0.1 + gap : 0.1), d});
        }
        std::vector<RayStart> starts = start_rays(*plan, rays);
        const Double3 corner = point_of_triangle(*plan, 0, 0, 0, 0), to_u = point_of_triangle(*plan, 0, 0, 1, 0);
        const bool first_triangle =
            dot(cross(subtract(to_u, corner), subtract(scaled(normal, 0.1), corner)),
                cross(subtract(to_u, corner), subtract(point_of_triangle(*plan, 0, 0, 0, 1), corner))) > 0;
        for (std::size_t i = 0; i < starts.size(); ++i) {
            starts[i].surface = i & 1;
            starts[i].primitive = i & 1 || first_triangle ? 0 : 1;
        }
        const std::vector<RayEnd> ends = ends_of(*plan, starts);
        for (std::size_t i = 0; i < ends.size(); ++i) {
            const bool on_sphere = i & 1, is_upward = i & 2;
            const bool inside = on_sphere && is_upward, leaves = !on_sphere && !is_upward;
            ASSERT_EQ(ends[i].status, leaves ? Status::escaped : Status::hit) << i << " gap " << gap;
            if (leaves) continue;
            ASSERT_EQ(ends[i].surface, is_upward ? 1u : 0u) << i << " gap " << gap;
            const double distance = length(subtract(point_of(ends[i]), rays[i].position));
            if (inside) ASSERT_GT(distance, 0.1) << i << " gap " << gap;
            else ASSERT_LT(distance, 10 * gap) << i << " gap " << gap;
        }
    }
}

const Case cases[] = {{"scalar", 0}, {"scalar", 1}, {"scalar", 2}, {"packet", 0}, {"packet", 1}, {"packet", 2}};
std::string name_of(const testing::TestParamInfo<Case>& info) {
    return std::string(info.param.strategy) + std::array{"Flat", "Gradient", "Fisheye"}[std::size_t(info.param.space)];
}
INSTANTIATE_TEST_SUITE_P(Spaces, SurfaceStarts, testing::ValuesIn(cases), name_of);
INSTANTIATE_TEST_SUITE_P(Spaces, ReflectingBodies, testing::ValuesIn(cases), name_of);

}  // namespace
}  // namespace kagero::test
