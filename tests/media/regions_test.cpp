// Tests of the regions of media: the medium of points against closed forms, and messages for wrong boundaries.
#include "media/regions.h"

#include "tests/support/scene_fixture.h"

#include "plan/plan.h"
#include "scene/value.h"

#include <random>

namespace kagero::test {
namespace {

/// A scene without objects, with the media glass and water.
const std::string two_media =
    "[space]\nhamiltonian = \"flat\"\n[[medium]]\nname = \"glass\"\nhamiltonian = \"uniform\"\n"
    "[[medium]]\nname = \"water\"\nhamiltonian = \"uniform\"\nn0 = 1.33\n"
    "[camera]\nposition = [0.1, -9.3, 0.2]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [4, 4]\n";

/// Returns the text of a boundary.
std::string boundary(const std::string& name, const std::string& shape, const std::string& interior,
                     const std::string& exterior) {
    return "[[object]]\nname = \"" + name + "\"\n" + shape + "\nmaterial = \"boundary\"\ninterior = \"" + interior +
           "\"\nexterior = \"" + exterior + "\"\n";
}
std::string sphere(const std::string& center, const std::string& radius) {
    return "shape = \"sphere\"\ncenter = [" + center + "]\nradius = " + radius;
}
std::string box(const std::string& min, const std::string& max, const std::string& shape = "box") {
    return "shape = \"" + shape + "\"\nmin = [" + min + "]\nmax = [" + max + "]";
}

/// Appends the octahedron |x| + |y| + |z| = radius, around (shift, 0, 0), to the text of an OBJ file. Every triangle
/// has its own vertices. Its normals point outward unless it is reversed.
void append_octahedron(std::string& obj, double radius, bool reversed, double shift = 0) {
    auto first = 1 + std::count(obj.begin(), obj.end(), 'v');
    for (int octant = 0; octant < 8; ++octant) {
        const double x = octant & 1 ? -1 : 1, y = octant & 2 ? -1 : 1, z = octant & 4 ? -1 : 1;
        const auto line = [&](double a, double b, double c) {
            obj += "v " + std::to_string(shift + radius * a) + ' ' + std::to_string(radius * b) + ' ' +
                   std::to_string(radius * c) + '\n';
        };
        line(x, 0, 0);
        line(0, y, 0);
        line(0, 0, z);
        const bool swap = (x * y * z < 0) != reversed;
        obj += "f " + std::to_string(first) + ' ' + std::to_string(first + (swap ? 2 : 1)) + ' ' +
               std::to_string(first + (swap ? 1 : 2)) + '\n';
        first += 3;
    }
}

double octahedral_norm(const Double3& q) { return std::abs(q[0]) + std::abs(q[1]) + std::abs(q[2]); }

class RegionsOfMedia : public SceneTest {
protected:
    std::shared_ptr<const Scene> scene_of(const std::string& objects, const std::vector<Override>& keys = {}) const {
        return make_scene(load_scene_text(two_media + objects, "scene.toml", keys, catalogue("auto")), Options{},
                          Purpose::picture);
    }
    View view_of(const std::string& objects, const std::vector<Override>& keys = {}) const {
        return make_plan(load_scene_text(two_media + objects, "scene.toml", keys, catalogue("auto")), Options{}).view;
    }
    std::string refusal_of(const std::string& objects, const std::vector<Override>& keys = {}) const {
        try {
            view_of(objects, keys);
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    }
    /// Returns the keys of a mesh whose OBJ file has this text.
    std::string mesh(const std::string& obj, const std::string& name = "mesh.obj") const {
        return "shape = \"mesh\"\nfile = \"" + write(name, obj) + "\"";
    }
    /// Compares medium_at with a closed form at random points with coordinates up to `extent`.
    template <class Expected>
    static void expect_media(const Scene& scene, double extent, const Expected& expected) {
        std::mt19937 random(7);
        std::uniform_real_distribution<double> coordinate(-extent, extent);
        std::array<int, 3> counts{};
        for (int i = 0; i < 3000; ++i) {
            const Double3 q{coordinate(random), coordinate(random), coordinate(random)};
            const std::uint32_t medium = scene.regions->medium_at(q);
            ++counts.at(medium);
            ASSERT_EQ(medium, expected(q)) << to_toml(q);
        }
        EXPECT_GT(counts[0], 20);
        EXPECT_GT(counts[1], 20);
    }
};

TEST_F(RegionsOfMedia, OfNestedSpheres) {
    const auto scene = scene_of(boundary("ball", sphere("0, 0, 0", "2"), "glass", "space") +
                                boundary("drop", sphere("0.5, 0, 0", "1"), "water", "glass") +
                                boundary("bubble", sphere("0.5, 0.25, 0", "0.5"), "space", "water"));
    expect_media(*scene, 2.5, [](const Double3& q) -> std::uint32_t {
        if (length(subtract(q, {0.5, 0.25, 0})) < 0.5) return 0;
        if (length(subtract(q, {0.5, 0, 0})) < 1) return 2;
        return length(q) < 2 ? 1 : 0;
    });
    for (std::uint32_t i = 0; i < 3; ++i) EXPECT_EQ(scene->regions->outward_sign(i), 1);
}

// The boxes share the face x = 0, and the room touches a face of the second box from inside.
TEST_F(RegionsOfMedia, OfTouchingBoxesAndRooms) {
    const auto scene = scene_of(boundary("left", box("-2, -1, -1", "0, 1, 1"), "glass", "space") +
                                boundary("right", box("0, -1, -1", "2, 1, 1"), "water", "space") +
                                boundary("room", box("1, -0.5, -0.5", "2, 0.5, 0.5", "room"), "glass", "water"));
    expect_media(*scene, 2.5, [](const Double3& q) -> std::uint32_t {
        const double side = std::max(std::abs(q[1]), std::abs(q[2]));
        if (side > 1 || std::abs(q[0]) > 2) return 0;
        return q[0] < 0 || (q[0] > 1 && side < 0.5) ? 1 : 2;
    });
    EXPECT_EQ(scene->regions->outward_sign(0), 1);
    EXPECT_EQ(scene->regions->outward_sign(2), -1);  // the triangles of a room face inward
}

TEST_F(RegionsOfMedia, OfMeshesInBothOrientations) {
    for (const bool reversed : {false, true}) {
        std::string obj;
        append_octahedron(obj, 2, reversed);
        const auto scene = scene_of(boundary("gem", mesh(obj), "glass", "space") +
                                    boundary("drop", sphere("0, 0, 0", "0.75"), "water", "glass"));
        expect_media(*scene, 2, [](const Double3& q) -> std::uint32_t {
            return length(q) < 0.75 ? 2 : octahedral_norm(q) < 2 ? 1 : 0;
        });
        EXPECT_EQ(scene->regions->outward_sign(0), reversed ? -1 : 1);
        // The planes that the kernels use, times this sign, point away from the origin.
        const Surface& surface = scene->geometry->kernel_view()->surfaces[0];
        for (int triangle = 0; triangle < 8; ++triangle)
            EXPECT_GT(scene->regions->outward_sign(0) * surface.planes[4 * triangle + 3], 0);
    }
}

TEST_F(RegionsOfMedia, OfAMeshWithACavity) {
    for (const bool reversed : {false, true}) {
        std::string obj;
        append_octahedron(obj, 2, reversed);
        append_octahedron(obj, 1, !reversed);
        const auto scene = scene_of(boundary("shell", mesh(obj), "glass", "space"));
        expect_media(*scene, 2, [](const Double3& q) -> std::uint32_t {
            return octahedral_norm(q) < 2 && octahedral_norm(q) > 1 ? 1 : 0;
        });
    }
}

// A lens of glass and one of water with a common face, both as meshes: a cube that is cut along a diagonal plane.
TEST_F(RegionsOfMedia, OfMeshesWithACommonFace) {
    const std::string corners = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n";
    const std::string below = "f 1 3 2\nf 5 6 7\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 1 5\nf 3 5 7\n";
    const std::string above = "f 1 4 3\nf 5 7 8\nf 1 3 7\nf 1 7 5\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";
    const auto scene = scene_of(boundary("below", mesh(corners + below, "below.obj"), "glass", "space") +
                                boundary("above", mesh(corners + above, "above.obj"), "water", "space"));
    expect_media(*scene, 1.5, [](const Double3& q) -> std::uint32_t {
        if (std::max({std::abs(q[0]), std::abs(q[1]), std::abs(q[2])}) > 1) return 0;
        return q[1] < q[0] ? 1 : 2;
    });
}

// The centre of the space is the origin of coordinates, and the unit of length is that of the kernels.
TEST_F(RegionsOfMedia, HaveCoordinatesRelativeToTheCenterOfTheSpace) {
    const auto scene = scene_of(boundary("ball", sphere("3e9, 0, 0", "1e9"), "glass", "space"),
                                {"space.center=[1e9,0,0]", "integrator.escape_radius=1e10"});
    const double unit = scene->unit;
    EXPECT_GT(unit, 1);
    expect_media(*scene, 3e9 / unit, [&](const Double3& q) -> std::uint32_t {
        return length(subtract(q, {2e9 / unit, 0, 0})) < 1e9 / unit ? 1 : 0;
    });
}

// A small object far from large ones keeps its shape: rounding is relative to the object, not to the scene.
TEST_F(RegionsOfMedia, OfSmallObjectsInALargeScene) {
    const auto scene = scene_of(boundary("planet", sphere("0, 0, -6371000", "6371000"), "water", "space") +
                                    boundary("lens", box("0, 0, 2", "0.001, 0.001, 2.001"), "glass", "space"),
                                {"integrator.escape_radius=1e7", "camera.position=[0,-9,1]"});
    const auto medium_at = [&](const Double3& q) { return scene->regions->medium_at(scaled(q, 1 / scene->unit)); };
    EXPECT_EQ(medium_at({0.0005, 0.0005, 2.0005}), 1u);
    EXPECT_EQ(medium_at({0.0005, 0.0005, 2.0015}), 0u);
    EXPECT_EQ(medium_at({0.0005, 0.0005, 1.9995}), 0u);
    EXPECT_EQ(medium_at({0, 0, -0.001}), 2u);
}

TEST_F(RegionsOfMedia, DiscardRaysThroughEdgesAndTangents) {
    const auto description = scene_of(boundary("cube", box("-1, -1, -1", "1, 1, 1"), "glass", "space") +
                                      boundary("ball", sphere("5, 0, 0", "1"), "water", "space"));
    const Boundaries boundaries(description->description, *description->geometry, 1);
    const auto cast = [&](const Double3& from, const Double3& to) {
        return boundaries.cast({from, unit(subtract(to, from))});
    };
    EXPECT_FALSE(cast({-3, -3, -3}, {-1, -1, -1}));    // a vertex
    EXPECT_FALSE(cast({-3, 0.3, -3}, {-1, 0.3, -1}));  // an edge of the cube
    // One diagonal of a face is an edge of its triangles, the other one is not.
    const bool first_is_certain = cast({-3, 0.25, 0.25}, {1, 0.25, 0.25}).has_value();
    EXPECT_EQ(cast({-3, 0.25, -0.25}, {1, 0.25, -0.25}).has_value(), !first_is_certain);
    EXPECT_FALSE(cast({5, 1, -3}, {5, 1, 3}));  // a tangent of the sphere
    EXPECT_TRUE(cast({5, 1.0001, -3}, {5, 1.0001, 3}));
    const auto hit = cast({-3, 0.3, 0.1}, {1, 0.3, 0.2});
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->medium, 0u);
    EXPECT_FALSE(hit->from_inside);
    EXPECT_EQ(cast({0, 0.3, 0.1}, {1, 0.3, 0.2})->medium, 1u);
    EXPECT_EQ(cast({5, 0.1, 0.2}, {9, 0.3, 0.2})->medium, 2u);
}

TEST_F(RegionsOfMedia, AreMadeOnlyForScenesWithBoundaries) {
    const std::string ball = "[[object]]\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\n";
    EXPECT_EQ(scene_of(ball)->regions, nullptr);
    EXPECT_EQ(scene_of(ball + "material = \"mirror\"\n")->regions, nullptr);
    EXPECT_NE(scene_of(ball + "material = \"boundary\"\ninterior = \"glass\"\n")->regions, nullptr);
    EXPECT_EQ(view_of(ball).medium, 0u);
}

TEST_F(RegionsOfMedia, ContainTheCamera) {
    const std::string ball = boundary("ball", sphere("0, 0, 0", "2"), "glass", "space");
    EXPECT_EQ(view_of(ball).medium, 0u);
    EXPECT_EQ(view_of(ball, {"camera.position=[0,-1,0.5]"}).medium, 1u);
    EXPECT_EQ(view_of(ball, {"camera.position=[0,-1,0.5]", "camera.medium=glass"}).medium, 1u);
    EXPECT_EQ(view_of(ball, {"camera.medium=space"}).medium, 0u);
    EXPECT_EQ(refusal_of(ball, {"camera.medium=glass"}),
              "-D camera.medium=glass: camera.medium = \"glass\", but the camera at camera.position = [0.1, -9.3, 0.2] "
              "is in \"space\": a straight ray from it crosses no boundary; state \"space\" or \"auto\", or move the "
              "camera");
    EXPECT_NE(refusal_of(ball, {"camera.position=[0,-1,0.5]", "camera.medium=water"})
                  .find("is in \"glass\": a straight ray from it first crosses object.ball from inside"),
              std::string::npos);
    EXPECT_NE(refusal_of("", {"camera.medium=water"}).find("is in \"space\": the scene has no boundary"),
              std::string::npos);
}

TEST_F(RegionsOfMedia, RefuseMeshesThatEncloseNothing) {
    std::string closed;
    append_octahedron(closed, 2, false);
    std::string open = closed.substr(0, closed.rfind("f "));
    std::string reversed = open + "f 22 24 23\n";
    if (closed.ends_with("f 22 24 23\n")) reversed = open + "f 22 23 24\n";
    std::string shared = closed;
    append_octahedron(shared, 2, false);
    EXPECT_EQ(refusal_of(boundary("gem", mesh(closed), "glass", "space")), "");
    const std::string at = "scene.toml:20:12: object.gem.material = \"boundary\" needs a closed mesh, but \"";
    const auto expect = [&](const std::string& obj, const std::string& fragment) {
        const std::string message = refusal_of(boundary("gem", mesh(obj), "glass", "space"));
        EXPECT_EQ(message.substr(0, at.size()), at) << message;
        EXPECT_NE(message.find(fragment), std::string::npos) << message;
    };
    expect(open, "is open: 3 edges belong to one triangle only, for example that from [");
    expect(open, "close the mesh, or choose another material");
    expect(reversed, "is not consistently oriented: 3 edges belong to two triangles that traverse it in the same ");
    expect(shared, "is not the surface of one region: 12 edges belong to more than two triangles");
    EXPECT_EQ(refusal_of("[[object]]\n" + mesh(open) + "\nmaterial = \"mirror\"\n"), "");
}

TEST_F(RegionsOfMedia, RefuseBoundariesThatContradictEachOther) {
    std::string parts, shell;
    append_octahedron(parts, 1, false);
    append_octahedron(parts, 0.5, true, 4);  // beside the first part, but reversed
    append_octahedron(shell, 2, false);
    append_octahedron(shell, 1, false);  // a cavity whose normals point outward
    const std::string ball = boundary("ball", sphere("0, 0, 0", "2"), "glass", "space");
    struct {
        std::string objects;
        const char* position;
        const char* fragment;
    } const cases[] = {
        {ball + boundary("drop", sphere("0, 0, 0", "1"), "water", "space"), "22:12",
         "object.ball.interior = \"glass\", but a straight ray from just inside the object at ["},
        {ball + boundary("drop", sphere("0, 0, 0", "1"), "water", "space"), "22:12",
         "next crosses object.drop from outside, where object.drop.exterior = \"space\"; both keys name the medium of "
         "the region between the objects, so change object.ball.interior or object.drop.exterior"},
        {boundary("drop", sphere("0, 0, 0", "1"), "water", "space") + ball, "23:12",
         "next crosses object.ball from inside, where object.ball.interior = \"glass\""},
        {ball + boundary("other", sphere("2, 0, 0", "1"), "water", "space"), "2", "object."},  // overlapping
        {ball + boundary("same", sphere("2, 0, 0", "1"), "glass", "space"), "2", "object."},   // overlapping
        {boundary("ball", sphere("0, 0, 0", "2"), "glass", "water"), "23:12",
         "crosses no boundary, so that the medium there is \"space\"; change object.ball.exterior, or enclose"},
        {boundary("parts", mesh(parts, "parts.obj"), "glass", "space"), "2",
         "crosses no boundary, so that the medium there is \"space\"; reverse the triangles of this part of the mesh"},
        {boundary("shell", mesh(shell, "shell.obj"), "glass", "space"), "2", "so reverse the triangles of some parts"},
    };
    for (const auto& [objects, position, fragment] : cases) {
        const std::string message = refusal_of(objects);
        EXPECT_NE(message.find("scene.toml:" + std::string(position)), std::string::npos) << objects << message;
        EXPECT_NE(message.find(fragment), std::string::npos) << objects << message;
    }
    EXPECT_EQ(refusal_of(ball + boundary("drop", sphere("0, 0, 0", "1"), "water", "glass")), "");
}

// Two boxes at the same place state two media for one region.
TEST_F(RegionsOfMedia, RefuseCoincidentBoundaries) {
    const auto scene = scene_of(boundary("one", box("-1, -1, -1", "1, 1, 1"), "glass", "space") +
                                boundary("two", box("-1, -1, -1", "1, 1, 1"), "water", "space"));
    EXPECT_EQ(scene->regions->medium_at({3, 0, 0}), 0u);
    EXPECT_THROW(scene->regions->medium_at({0, 0, 0}), InputError);
}

}  // namespace
}  // namespace kagero::test
