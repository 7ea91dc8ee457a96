// Tests of accretion disks: edges, colours, and the redshift of the orbiting matter, compared with closed forms.
#include "tests/support/plan_fixture.h"
#include "appearance/redshift.h"
#include "appearance/blackbody.h"
#include "scene/vector3.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace kagero::test {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

const char* const disk = R"([space]
hamiltonian = "schwarzschild"
rg = 1
[integrator]
escape_radius = 60
[camera]
position = [0, -29.5, 5.2]
look_at = [0, 0, 0]
up = [0, 0, 1]
fov = 50
[film]
size = [48, 32]
layers = ["color", "redshift", "status", "object", "depth"]
[sky]
color = [0, 0, 1]
[[object]]
name = "disk"
shape = "disk"
center = [0, 0, 0]
inner = 1.6
outer = 15
color = [1, 1, 1]
)";

Film picture(const Plan& plan) {
    Film film = film_of(plan);
    render(plan, film);
    return film;
}

/// Camera rays of all pixels, and their ends. The positions of the ends are relative to `space.center`.
struct TracedPicture {
    std::vector<CameraRay> rays;
    std::vector<RayEnd> ends;

    explicit TracedPicture(const Plan& plan) {
        std::vector<RayStart> starts;
        for (std::uint32_t y = 0; y < plan.description().film.height; ++y)
            for (std::uint32_t x = 0; x < plan.description().film.width; ++x) {
                rays.push_back(camera_ray(plan, x + 0.5, y + 0.5));
                starts.push_back(rays.back().start);
            }
        trace(plan, starts, ends);
        for (RayEnd& end : ends)
            for (std::size_t k = 0; k < 3; ++k) end.q[k] -= plan.description().space.center[k];
    }
};

/// Returns the observed frequency of the light of pixel `i` divided by its frequency at infinity, for r_g = 1. A static
/// observer measures 1/√(1 − 1/r). An observer that falls from rest at infinity has the speed v = 1/√r and measures
/// 1/(1 + v cos χ), with the angle χ between the ray and the outward direction. This follows from ∂_t = u + v e_r with
/// the observer's 4-velocity u and outward unit vector e_r, because the energy −p·∂_t is conserved.
double blueshift_from_infinity(const Plan& plan, const RayStart& s, std::uint32_t i) {
    const double r = std::hypot(s.q[0], s.q[1], s.q[2]);
    if (plan.description().camera.observer != ObserverKind::falling) return 1 / std::sqrt(1 - 1 / r);
    const CameraRays& c = plan.view.camera;
    Double3 d;
    for (std::size_t k = 0; k < 3; ++k)
        d[k] = c.corner[k] + (i % c.width + 0.5) * c.right[k] + (i / c.width + 0.5) * c.down[k];
    return 1 / (1 + std::sqrt(1 / r) * dot(unit(d), {s.q[0] / r, s.q[1] / r, s.q[2] / r}));
}

// The redshift g is the observed frequency divided by the emitted one. 1/g is (1 − ω L/E) / √(1 − 3/(2r)), divided by
// the blueshift of the observer. ω is the angular velocity of the matter, for r_g = 1. L and E are the angular momentum
// and energy of the light: L/E = −(q × p)_z / |p_t|, because a traced ray runs backward in time.
TEST(Redshift, MatchesTheClosedFormForCircularOrbitsAroundSchwarzschild) {
    for (const auto& [center, observer] :
         {std::pair{"[0,0,0]", "static"}, {"[0.5,1,-0.25]", "static"}, {"[0,0,0]", "zamo"}, {"[0,0,0]", "falling"}}) {
        const auto plan =
            plan_of_text(disk, {std::string("space.center=") + center, std::string("object.disk.center=") + center,
                                std::string("camera.observer=") + observer});
        const TracedPicture traced(*plan);
        int hits = 0;
        double least = 10, greatest = 0;
        for (std::size_t i = 0; i < traced.ends.size(); ++i) {
            const RayEnd& end = traced.ends[i];
            if (end.status != Status::hit) continue;
            const RayStart& s = traced.rays[i].start;
            const double observer_factor = blueshift_from_infinity(*plan, s, static_cast<std::uint32_t>(i));
            const double r = std::hypot(end.q[0], end.q[1], end.q[2]);
            const double l_over_e = -(s.q[0] * s.p[1] - s.q[1] * s.p[0]) / std::abs(s.pt),
                         omega = std::sqrt(0.5) / std::pow(r, 1.5);
            const double expected = observer_factor * std::sqrt(1 - 1.5 / r) / (1 - omega * l_over_e);
            const double g = redshift_of(*plan, {&end, &traced.rays[i]});
            // The tolerance covers the integration error of p at the end of the ray, and rounding.
            EXPECT_NEAR(g / expected, 1, 1e-9) << i << " " << observer;
            least = std::min(least, g);
            greatest = std::max(greatest, g);
            ++hits;
        }
        EXPECT_GT(hits, 200);
        EXPECT_LT(least, 0.4);
        EXPECT_GT(greatest, 1.2);
    }
}

// Matter orbits in the right-handed sense around the normal. Seen from −y with the normal up, the matter in the left
// half of the picture approaches the camera. With the opposite normal, the picture is mirrored.
TEST(Redshift, IsGreaterOnTheApproachingSide) {
    const auto up = plan_of_text(disk, {}), down = plan_of_text(disk, {"object.disk.normal=[0,0,-1]"});
    Film a = picture(*up), b = picture(*down);
    int compared = 0;
    for (std::uint32_t y = 0; y < 32; ++y)
        for (std::uint32_t x = 0; x < 20; ++x) {
            const double left = *a.pixel("redshift", x, y), right = *a.pixel("redshift", 47 - x, y);
            if (*a.pixel("status", x, y) != 0) continue;
            EXPECT_GT(left, right);
            EXPECT_GT(*a.pixel("color", x, y), *a.pixel("color", 47 - x, y));
            EXPECT_NEAR(*b.pixel("redshift", 47 - x, y), left, 1e-6);
            ++compared;
        }
    EXPECT_GT(compared, 50);
}

TEST(Redshift, ScalesColorsWithItsFourthPower) {
    const auto plan = plan_of_text(disk, {});
    Film film = picture(*plan);
    for (std::uint32_t y = 0; y < 32; ++y)
        for (std::uint32_t x = 0; x < 48; ++x)
            if (*film.pixel("object", x, y) == 1) {
                EXPECT_NEAR(*film.pixel("color", x, y) / std::pow(*film.pixel("redshift", x, y), 4), 1, 1e-5);
            }
}

// At the edges of the disk, Embree must return the same hits for single rays and for packets.
TEST(Disk, LooksTheSameForEveryStrategyAndNumberOfThreads) {
    Options options = with_strategy("packet");
    Film packet = picture(*plan_of_text(disk, {}, options)),
         scalar = picture(*plan_of_text(disk, {}, with_strategy("scalar")));
    options.threads = 3;
    Film threaded = picture(*plan_of_text(disk, {}, options));
    for (const char* layer : {"color", "redshift", "status"})
        for (std::uint32_t y = 0; y < 32; ++y)
            for (std::uint32_t x = 0; x < 48; ++x) {
                ASSERT_EQ(*packet.pixel(layer, x, y), *scalar.pixel(layer, x, y)) << layer << " " << x << "," << y;
                ASSERT_EQ(*packet.pixel(layer, x, y), *threaded.pixel(layer, x, y)) << layer << " " << x << "," << y;
            }
}

TEST(Redshift, IsOneWithoutABlackHole) {
    for (const char* space : {"space.rg=0", "space={hamiltonian=\"flat\"}"}) {
        const auto plan = plan_of_text(disk, {space});
        const TracedPicture traced(*plan);
        for (std::size_t i = 0; i < traced.ends.size(); ++i)
            EXPECT_NEAR(redshift_of(*plan, {&traced.ends[i], &traced.rays[i]}), 1, 16 * epsilon) << space;
    }
}

// The source of the sky's light is at rest at infinity. For escaped rays, the redshift g is therefore the observer's
// blueshift. For captured rays it is 0.
TEST(Redshift, IsTheBlueshiftOfTheObserverForTheSky) {
    for (const char* observer : {"static", "falling"}) {
        const auto plan = plan_of_text(disk, {"object.disk.outer=2", std::string("camera.observer=") + observer});
        const TracedPicture traced(*plan);
        int escaped = 0, captured = 0;
        for (std::size_t i = 0; i < traced.ends.size(); ++i) {
            const double g = redshift_of(*plan, {&traced.ends[i], &traced.rays[i]});
            if (traced.ends[i].status == Status::escaped) {
                ++escaped;
                EXPECT_NEAR(g, blueshift_from_infinity(*plan, traced.rays[i].start, static_cast<std::uint32_t>(i)),
                            32 * epsilon);
            }
            if (traced.ends[i].status == Status::captured) {
                ++captured;
                EXPECT_EQ(g, 0);
            }
        }
        EXPECT_GT(escaped, 100);
        EXPECT_GT(captured, 5);
    }
}

// Within the photon sphere at r = 1.5 r_g, matter cannot orbit freely, and the disk is dark.
TEST(Redshift, IsZeroForMatterWithinThePhotonSphere) {
    const auto plan = plan_of_text(disk, {"object.disk.inner=0.5"});
    for (const double r : {1.2, 1.49, 1.51, 3.0}) {
        RayEnd end{};
        end.status = Status::hit;
        end.q[0] = r;
        end.p[2] = end.pt = 1;
        const CameraRay ray{{}, 1};
        EXPECT_EQ(redshift_of(*plan, {&end, &ray}) > 0, r > 1.5) << r;
    }
}

bool has_kerr() {
    const Catalogue spaces = catalogue("auto");
    return std::any_of(spaces.hamiltonians, spaces.hamiltonians + spaces.hamiltonian_count,
                       [](const HamiltonianInfo& info) { return std::string(info.name) == "kerr"; });
}

// The emitted frequency is u^t (p_t + ω L), with u^t = (r^{3/2} + a√M) / (r^{3/4} √(r^{3/2} − 3M√r + 2a√M)), and
// ω = √M/(r^{3/2} + a√M) for circular equatorial orbits (Bardeen et al. 1972). a is negative for retrograde orbits.
TEST(Redshift, MatchesTheClosedFormForCircularOrbitsAroundKerr) {
    if (!has_kerr()) GTEST_SKIP() << "the kernel modules were built without kerr";
    for (const double normal_z : {1.0, -1.0}) {
        const auto plan = plan_of_text(disk, {"space={hamiltonian=\"kerr\", mass=0.5, spin=0.8}", "object.disk.inner=4",
                                              "object.disk.normal=[0,0," + std::to_string(normal_z) + "]"});
        const TracedPicture traced(*plan);
        std::size_t hits = 0;
        for (std::size_t i = 0; i < traced.ends.size(); ++i) {
            const RayEnd& end = traced.ends[i];
            if (end.status != Status::hit) continue;
            ++hits;
            const double a = 0.4 * normal_z, sqrt_m = std::sqrt(0.5);
            const double r = std::sqrt(end.q[0] * end.q[0] + end.q[1] * end.q[1] - a * a), rr = std::pow(r, 1.5);
            const double ut = (rr + a * sqrt_m) /
                              (std::pow(r, 0.75) * std::sqrt(rr - 1.5 * std::sqrt(r) + 2 * a * sqrt_m));
            const double angular_momentum = (end.q[0] * end.p[1] - end.q[1] * end.p[0]) * normal_z;
            const double emitted = ut * (end.pt + sqrt_m / (rr + a * sqrt_m) * angular_momentum);
            const double g = redshift_of(*plan, {&end, &traced.rays[i]});
            EXPECT_NEAR(g * emitted / traced.rays[i].frequency, 1, 1e-11) << i;
        }
        EXPECT_GT(hits, 100u);
    }
}

double energy_of(const RayStart& start) { return start.ingoing ? -start.pt : start.pt; }
// Within the ergosphere, matter can emit light of negative energy, which cannot come from the sky. An observer inside
// the ergosphere, such as a zamo or an observer at rest in the coordinates, receives this light with a positive
// redshift factor. The emitted frequency is the closed form of the test above.
TEST(Redshift, MatchesTheClosedFormForLightOfNegativeEnergy) {
    if (!has_kerr()) GTEST_SKIP() << "the kernel modules were built without kerr";
    for (const auto& [observer, look_at] : {std::pair{"zamo", "[10,-1.9,0]"}, {"coordinate", "[0,-10,0]"}}) {
        const Overrides overrides{"space={hamiltonian=\"kerr\", mass=1, spin=0.998}",
                                  "object.disk.inner=1.62",
                                  "object.disk.outer=9",
                                  "camera.position=[0,-1.9,0.25]",
                                  "camera.fov=80",
                                  "film.size=[24,16]",
                                  "integrator.max_steps=100000",
                                  std::string("camera.observer=") + observer,
                                  std::string("camera.look_at=") + look_at};
        const auto plan = plan_of_text(disk, overrides);
        const TracedPicture traced(*plan);
        int negative = 0;
        for (std::size_t i = 0; i < traced.ends.size(); ++i) {
            const RayEnd& end = traced.ends[i];
            if (energy_of(traced.rays[i].start) >= 0) continue;
            EXPECT_NE(end.status, Status::escaped) << i;
            if (end.status != Status::hit) continue;
            ++negative;
            const double a = 0.998, r = std::sqrt(end.q[0] * end.q[0] + end.q[1] * end.q[1] - a * a),
                         rr = std::pow(r, 1.5);
            const double ut = (rr + a) / (std::pow(r, 0.75) * std::sqrt(rr - 3 * std::sqrt(r) + 2 * a));
            const double emitted = ut * (end.pt + (end.q[0] * end.p[1] - end.q[1] * end.p[0]) / (rr + a));
            const double g = redshift_of(*plan, {&end, &traced.rays[i]});
            EXPECT_GT(g, 0) << i;
            EXPECT_NEAR(g * emitted / traced.rays[i].frequency, 1, 1e-6) << observer << ' ' << i;
        }
        EXPECT_GT(negative, 10) << observer;
        // In a scene without surfaces, a ray of negative energy is captured at its start.
        const auto sky_plan =
            plan_of_text(std::string(disk).substr(0, std::string(disk).find("[[object]]")),
                         {overrides[0], overrides[3], overrides[4], overrides[5], overrides[7], overrides[8]});
        const TracedPicture sky_picture(*sky_plan);
        for (std::size_t i = 0; i < sky_picture.ends.size(); ++i)
            EXPECT_TRUE(energy_of(sky_picture.rays[i].start) > 0 || sky_picture.ends[i].status == Status::captured);
    }
}

// The camera is orthographic and above the disk, in flat space. A pixel is 1/40 wide, in scene units. Pixels whose
// centre is within 1e-5 of an edge are left out, because rounding decides their status.
TEST(Disk, HasCircularInnerAndOuterEdges) {
    const auto plan = plan_of_text(disk, {"space={hamiltonian=\"flat\"}", "camera.type=orthographic",
                                          "camera.position=[0,0,5]", "camera.up=[0,1,0]", "camera.height=4",
                                          "film.size=[240,160]", "object.disk.inner=0.7", "object.disk.outer=1.8"});
    Film film = picture(*plan);
    for (std::uint32_t y = 0; y < 160; ++y)
        for (std::uint32_t x = 0; x < 240; ++x) {
            const double r = std::hypot(x - 119.5, y - 79.5) / 40;
            if (std::abs(r - 0.7) < 1e-5 || std::abs(r - 1.8) < 1e-5) continue;
            const bool on_disk = r > 0.7 && r < 1.8;
            ASSERT_EQ(*film.pixel("status", x, y), on_disk ? 0 : 1) << x << "," << y;
            ASSERT_EQ(*film.pixel("depth", x, y), on_disk ? 5.0f : 0.0f);
        }
}

// u increases from 0 to 1 around the disk, starting at +x, in the right-handed sense about the normal. v increases from
// the inner to the outer edge.
TEST(Disk, PaintCoordinatesAreAngleAndRadius) {
    const auto plan = plan_of_text(disk, {"object.disk.inner=1", "object.disk.outer=3", "object.disk.checker=[2,2]"});
    const auto bright = [&](double x, double y) {
        return plan->scene->paints->surface_color(0, 0, {x, y, 0}, {0, 0, -1})[0] == 1;
    };
    for (const double cosine : {-0.9, -0.1, 0.1, 0.9})
        for (const double r : {1.1, 1.9, 2.1, 2.9}) {
            const double sine = std::sqrt(1 - cosine * cosine);
            EXPECT_EQ(bright(r * cosine, r * sine), r < 2);
            EXPECT_EQ(bright(r * cosine, -r * sine), r > 2);
        }
}

// The key `temperature` is the value at the inner edge. It decreases as r^(−3/4). The observer sees g times the value.
TEST(Disk, IsHottestAtItsInnerEdge) {
    std::string text = disk;
    const std::string paint = "color = [1, 1, 1]";
    text.replace(text.find(paint), paint.size(), "temperature = 6000");
    const auto plan = plan_of_text(text, {});
    const auto color_at = [&](double r, double g) {
        return plan->scene->paints->surface_color(0, 0, {0, r, 0}, {0, 0, -1}, g);
    };
    const auto expect_color = [](const Float3& color, double kelvin) {
        const auto expected = blackbody_color(kelvin);
        const double unit = blackbody_luminance(6000);
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_NEAR(color[k], expected[k] / unit, 1e-6 * expected[0] / unit) << kelvin;
    };
    expect_color(color_at(1.6, 1), 6000);
    expect_color(color_at(1.6, 1.5), 9000);
    expect_color(color_at(1.6 * 16, 1), 750);
    EXPECT_EQ(color_at(2, 0), (Float3{0, 0, 0}));
}

TEST(Disk, IsRefusedIfItsMatterHasNoCircularOrbits) {
    const auto refusal = [](const Override& change) -> std::string {
        try {
            plan_of_text(disk, {change});
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_EQ(refusal("object.disk.center=[0,0,1]"),
              "-D object.disk.center=[0,0,1]: object.disk.center = [0, 0, 1]: expected space.center = "
              "[0, 0, 0], because the matter of a disk orbits the hole");
    EXPECT_NO_THROW(plan_of_text(disk, {"object.disk.center=[0,0,1]", "space.rg=0"}));
    EXPECT_NO_THROW(plan_of_text(disk, {"object.disk.normal=[0,1,1]"}));
}

}  // namespace
}  // namespace kagero::test
