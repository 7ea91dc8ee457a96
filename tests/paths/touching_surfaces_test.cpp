// Rays at surfaces that touch boundaries of media, or lie closer to them than floats distinguish: a block on a table, a
// mirror on the back of a plate, lenses that are cemented or nearly so. Light through plane faces keeps its direction
// and is displaced as in Snell's law.
#include "tests/support/plan_fixture.h"

#include "render/render.h"
#include "scene/vector3.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace kagero::test {
namespace {

const std::string head = R"([space]
hamiltonian = "flat"
[integrator]
escape_radius = 100
[camera]
position = [0, -4, 3]
look_at = [0, 0, 0]
up = [0, 0, 1]
[film]
size = [64, 48]
spp = 4
max_bounces = 12
[[medium]]
name = "glass"
hamiltonian = "uniform"
n0 = 1.5
[[medium]]
name = "water"
hamiltonian = "uniform"
n0 = 1.2
)";

std::string number(double value) {
    std::ostringstream text;
    text.precision(17);
    text << value;
    return text.str();
}

std::string box(const std::string& name, const Double3& min, const Double3& max, const std::string& medium) {
    const auto list = [](const Double3& q) {
        return "[" + number(q[0]) + ", " + number(q[1]) + ", " + number(q[2]) + "]\n";
    };
    return "[[object]]\nname = \"" + name + "\"\nshape = \"box\"\nmin = " + list(min) + "max = " + list(max) +
           "material = \"boundary\"\ninterior = \"" + medium + "\"\n";
}

std::string ball(const std::string& name, double x, double radius, const std::string& interior,
                 const std::string& exterior = "space") {
    return "[[object]]\nname = \"" + name + "\"\nshape = \"sphere\"\ncenter = [" + number(x) +
           ", 0, 0]\nradius = " + number(radius) + "\nmaterial = \"boundary\"\ninterior = \"" + interior +
           "\"\nexterior = \"" + exterior + "\"\n";
}

/// A square of side 10 in the plane z = height.
std::string square(double height, const std::string& material) {
    return "[[object]]\nname = \"square\"\nshape = \"rectangle\"\norigin = [-5, -5, " + number(height) +
           "]\nedge_u = [10, 0, 0]\nedge_v = [0, 10, 0]\nmaterial = \"" + material + "\"\n";
}

struct Traced {
    std::vector<RayEnd> ends;
    std::vector<PathState> paths;
};

class TouchingSurfaces : public testing::TestWithParam<std::string> {
protected:
    static Traced trace_rays(const std::string& objects, const std::vector<RayInput>& rays) {
        Options options;
        options.isa = GetParam();
        options.bounces = 12;
        const auto plan = plan_of_text(head + objects, {}, options, false);
        Traced traced;
        trace(*plan, start_rays(*plan, rays), traced.ends, {}, &traced.paths);
        return traced;
    }
    /// Returns the number of rays of a picture that fail, with the branches chosen at random.
    static std::uint64_t failed_rays_of_picture(const std::string& objects) {
        Options options;
        options.isa = GetParam();
        const auto plan = plan_of_text(head + objects, {}, options);
        Film film = film_of(*plan);
        return render(*plan, film).counters.ended[static_cast<int>(Status::failed)];
    }
};

INSTANTIATE_TEST_SUITE_P(Isas, TouchingSurfaces, testing::ValuesIn(supported_isas()),
                         [](const auto& isa) { return isa.param; });

/// Returns rays that meet the square |x|, |y| < 0.5 in the plane z = `height` from `from` above it.
std::vector<RayInput> rays_down(double height, double from) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> place(-0.5, 0.5), slope(-0.3, 0.3);
    std::vector<RayInput> rays;
    for (int i = 0; i < 200; ++i) {
        const double dx = slope(random), dy = slope(random);
        rays.push_back({{place(random) - dx * from, place(random) - dy * from, height + from}, {dx, dy, -1}});
    }
    return rays;
}

// The face of a block on a table is not a way around the table.
TEST_P(TouchingSurfaces, ABlockStandsOnATable) {
    for (const double height : {0.0, -1.0, -0.3, 0.1, -1.7, 0.37}) {
        const std::string objects =
            square(height, "surface") + box("block", {-1, -1, height}, {1, 1, height + 1}, "glass");
        const Traced traced = trace_rays(objects, rays_down(height, 3));
        for (const RayEnd& end : traced.ends) {
            EXPECT_EQ(end.status, Status::hit) << height;
            EXPECT_EQ(end.surface, 0u);
            EXPECT_NEAR(end.q[2], height, 1e-12);
        }
        for (const PathState& path : traced.paths) EXPECT_EQ(path.bounces, 1u) << height;
    }
}

// A mirror on the back of a plate reflects the light that has passed the plate: it leaves under the angle of incidence.
TEST_P(TouchingSurfaces, AMirrorIsOnTheBackOfAPlate) {
    for (const double gap : {0.0, 1e-10, 1e-8, 1e-7, 1e-6}) {
        const std::string objects = square(-gap, "mirror") + box("plate", {-2, -2, 0}, {2, 2, 1}, "glass");
        const std::vector<RayInput> rays = rays_down(0, 3);
        const Traced traced = trace_rays(objects, rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const Double3 d = unit(rays[i].direction);
            EXPECT_EQ(traced.ends[i].status, Status::escaped) << gap;
            EXPECT_GE(traced.paths[i].bounces, 3u);
            for (std::size_t k = 0; k < 3; ++k)
                EXPECT_NEAR(traced.ends[i].v[k], k == 2 ? -d[k] : d[k], 1e-9) << gap << ", ray " << i;
        }
    }
}

// What lies in front of a block hides it, however little it is in front.
TEST_P(TouchingSurfaces, AnOpaqueSurfaceIsInFrontOfABlock) {
    for (const double gap : {0.0, 1e-10, 1e-8, 1e-7, 1e-6}) {
        const std::string objects = square(1 + gap, "surface") + box("block", {-1, -1, 0}, {1, 1, 1}, "glass");
        const Traced traced = trace_rays(objects, rays_down(1, 2));
        for (std::size_t i = 0; i < traced.ends.size(); ++i) {
            EXPECT_EQ(traced.ends[i].surface, 0u) << gap;
            EXPECT_EQ(traced.paths[i].bounces, 0u) << gap;
        }
    }
}

/// Returns the position y where a ray of direction (1, slope, 0) from (−3, 0, 0) leaves a layer of index 1.5 from x =
/// −1 to x = middle, and one of index 1.2 to x = 1.
double exit_height(double slope, double middle) {
    const double sine = slope / std::sqrt(1 + slope * slope);
    const auto tangent = [&](double index) { return sine / std::sqrt(index * index - sine * sine); };
    return 2 * slope + (middle + 1) * tangent(1.5) + (1 - middle) * tangent(1.2);
}

TEST_P(TouchingSurfaces, LayersMayBeCloseToEachOther) {
    for (const double gap : {0.0, 1e-10, 1e-9, 3e-9, 1e-8, 1e-7, 1e-6}) {
        const std::string objects =
            box("A", {-1, -2, -2}, {0.1, 2, 2}, "glass") + box("B", {0.1 + gap, -2, -2}, {1, 2, 2}, "water");
        for (const double slope : {0.0, 0.1, 0.5}) {
            const Traced traced = trace_rays(objects, {{{-3, 0, 0}, {1, slope, 0}}, {{-3, 0, 0.1}, {1, slope, 0}}});
            for (const RayEnd& end : traced.ends) {
                ASSERT_EQ(end.status, Status::escaped) << gap;
                EXPECT_NEAR(end.v[1] / end.v[0], slope, 1e-12) << gap;
                EXPECT_NEAR(end.q[1] - slope * (end.q[0] - 1), exit_height(slope, 0.1), 1e-9 + 2 * gap) << gap;
            }
        }
        EXPECT_EQ(failed_rays_of_picture(objects), 0u) << gap;
    }
}

// The coordinates of mesh files are floats: the faces of a mesh and of a box at 0.3 differ by 1e-8.
TEST_P(TouchingSurfaces, AMeshMayTouchABox) {
    const auto path = std::filesystem::temp_directory_path() / ("kagero-cube-" + std::to_string(::getpid()) + ".obj");
    for (const double middle : {0.25, 0.3, 0.1, 0.7, 0.9, -0.3}) {
        std::ofstream file(path);
        file.precision(17);
        for (int i = 0; i < 8; ++i)
            file << "v " << (i & 1 ? 1 : middle) << ' ' << (i & 2 ? 2 : -2) << ' ' << (i & 4 ? 2 : -2) << '\n';
        file << "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
        file.close();
        const std::string objects = box("A", {-1, -2, -2}, {middle, 2, 2}, "glass") +
                                    "[[object]]\nname = \"B\"\nshape = \"mesh\"\nfile = \"" + path.string() +
                                    "\"\nmaterial = \"boundary\"\ninterior = \"water\"\n";
        for (const double slope : {0.0, 0.1, 0.5}) {
            const Traced traced = trace_rays(objects, {{{-3, 0, 0}, {1, slope, 0}}, {{3, 0, 0.1}, {-1, slope, 0}}});
            const RayEnd& end = traced.ends[0];
            ASSERT_EQ(end.status, Status::escaped) << middle;
            EXPECT_NEAR(end.v[1] / end.v[0], slope, 1e-12);
            EXPECT_NEAR(end.q[1] - slope * (end.q[0] - 1), exit_height(slope, middle), 1e-7) << middle;
            EXPECT_EQ(traced.ends[1].status, Status::escaped) << middle;
        }
        EXPECT_EQ(failed_rays_of_picture(objects), 0u) << middle;
    }
    std::filesystem::remove(path);
}

// Two balls touch in one point, where the gap between them is less than any rounding.
TEST_P(TouchingSurfaces, BallsMayTouchInAPoint) {
    const std::string objects = ball("A", -1, 1, "glass") + ball("B", 1, 1, "water");
    std::vector<RayInput> rays;
    for (const double y : {0.0, 1e-9, 1e-7, 1e-6, 1e-5, 3e-5, 6e-5, 1e-4, 3e-4, 1e-3})
        for (const double x : {-4.0, -1.0, 4.0}) rays.push_back({{x, y, 0}, {x < 0 ? 1.0 : -1.0, 0, 1e-9}});
    for (const RayEnd& end : trace_rays(objects, rays).ends) EXPECT_EQ(end.status, Status::escaped);
    EXPECT_EQ(failed_rays_of_picture(objects), 0u);
    // A ray that is tangent to a ball at its start is outside.
    for (const RayEnd& end : trace_rays(objects, {{{2, 0, 0}, {0, 1, 0}}, {{-2, 0, 0}, {0, 1, 0}}}).ends) {
        EXPECT_EQ(end.status, Status::escaped);
        EXPECT_NEAR(std::abs(end.q[0]), 2, 1e-12);
    }
}

TEST_P(TouchingSurfaces, ACoatingMayBeThin) {
    for (const double thickness : {1e-9, 1e-8, 1e-7, 1e-6})
        EXPECT_EQ(failed_rays_of_picture(ball("A", 0, 1, "glass") + ball("B", 0, 1 - thickness, "water", "glass")), 0u)
            << thickness;
}

// The discontinuity of a lens may be its boundary: steps then end on the boundary, except for rounding.
TEST_P(TouchingSurfaces, ALensMayEndOnItsBoundary) {
    const std::string lens =
        "[[medium]]\nname = \"lens\"\nhamiltonian = \"luneburg\"\nradius = 1\n" + ball("A", 0, 1, "lens");
    EXPECT_EQ(failed_rays_of_picture(lens), 0u);
    // Its rays leave through the point opposite to their direction, so that they form a cone behind it.
    std::vector<RayInput> rays;
    for (int i = 0; i < 200; ++i) rays.push_back({{-2, std::cos(i) * i / 201.0, std::sin(i) * i / 201.0}, {1, 0, 0}});
    for (const RayEnd& end : trace_rays(lens, rays).ends) {
        EXPECT_EQ(end.status, Status::escaped);
        for (const std::size_t k : {1u, 2u}) EXPECT_NEAR(end.q[k] * end.v[0] - (end.q[0] - 1) * end.v[k], 0, 1e-6);
    }
}

// All paths in a closed white room end at its lamp, so that every pixel has the colour of the lamp. Glass against the
// walls lets no light out of the room.
TEST_P(TouchingSurfaces, GlassAgainstAWallLetsNoLightThrough) {
    const std::string room = R"([[object]]
name = "room"
shape = "room"
min = [-1, -1, -1]
max = [1, 1, 1]
material = "diffuse"
color = [1, 1, 1]
[[object]]
name = "lamp"
shape = "sphere"
center = [0.3, -0.4, 0.6]
radius = 0.3
color = [1, 1, 1]
)";
    const Overrides film{"camera.position=[0, -0.9, 0]", "camera.look_at=[0, 1, 0]",
                         "film.size=[16, 12]",           "film.spp=16",
                         "film.max_bounces=1000",        R"(film.layers=["color", "standard_error"])"};
    for (const std::string& glass : {std::string(), box("block", {-0.5, 0.5, -0.5}, {0.5, 1, 0.5}, "glass"),
                                     box("half", {-1, 0.2, -1}, {1, 1, 1}, "glass")}) {
        Options options;
        options.isa = GetParam();
        const auto plan = plan_of_text(head + room + glass, film, options);
        Film picture = film_of(*plan);
        render(*plan, picture);
        double mean = 0, variance = 0;
        const std::size_t pixels = 16 * 12;
        for (std::size_t i = 0; i < pixels; ++i) {
            mean += double(picture.plane("color")[3 * i]) / pixels;
            variance += std::pow(double(picture.plane("standard_error")[3 * i]) / pixels, 2);
        }
        // Without a bound on the weights of paths, the error would exceed 1 in so bright a room.
        EXPECT_LT(std::sqrt(variance), 0.05) << glass;
        EXPECT_NEAR(mean, 1, 4 * std::sqrt(variance)) << glass;
    }
}

}  // namespace
}  // namespace kagero::test
