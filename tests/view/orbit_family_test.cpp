// Families of orbits: the interpolated ends of rays are compared with traced rays in random directions.
#include "view/sky/orbit_family.h"
#include "scene/load/load.h"
#include "scene/vector3.h"
#include "tuning/resolve.h"
#include "view/sky/map_picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace kagero::test {
namespace {

Plan plan_of(const std::string& scene, std::vector<Override> overrides = {}) {
    overrides.emplace_back("film.size=[320,180]");
    Options options;
    options.threads = 2;
    return resolve(load_scene(std::string(KAGERO_SCENES) + "/" + scene, overrides, catalogue("auto")), options);
}

/// Returns random unit vectors, of which half are within 0.3 of the direction to the centre.
std::vector<Double3> directions_from(const Plan& plan, std::size_t count) {
    const double* q = plan.view.camera.position;
    const Double3 to_centre = unit({-q[0], -q[1], -q[2]});
    std::mt19937 generator(1);
    std::normal_distribution<double> normal;
    std::vector<Double3> directions;
    for (std::size_t i = 0; i < count; ++i) {
        const Double3 random = unit({normal(generator), normal(generator), normal(generator)});
        directions.push_back(i % 2 == 0 ? random : unit(add(to_centre, scaled(random, 0.3))));
    }
    return directions;
}

struct Case {
    const char* scene;
    std::vector<Override> overrides;
};

TEST(OrbitFamily, EstimatesItsError) {
    constexpr double max_error = 1e-4;
    const Case cases[] = {{"galaxy.toml", {}},
                          {"hole.toml", {}},
                          {"hole.toml", {"camera.observer=falling"}},
                          {"wormhole.toml", {}},
                          {"wormhole.toml", {"camera.position=[0.1, 0.2, -0.1]"}}};
    for (const Case& c : cases) {
        SCOPED_TRACE(c.scene + (c.overrides.empty() ? std::string() : ", " + c.overrides[0].text));
        const Plan plan = plan_of(c.scene, c.overrides);
        ASSERT_TRUE(OrbitFamily::contains_rays_of(plan));
        OrbitFamily family(plan);
        family.refine(plan, max_error, 0.02, 1e-5);
        EXPECT_LT(family.rays(), 8000u) << "fewer rays than pixels in a few rows";
        const std::vector<Double3> directions = directions_from(plan, 4000);
        std::uint64_t rays = 0;
        double seconds = 0;
        const std::vector<SkyEnd> ends = trace_sky_ends(plan, directions, rays, seconds);
        std::size_t interpolated = 0, other_kind = 0, above = 0;
        OrbitFamily::Row row;
        for (std::size_t i = 0; i < ends.size(); ++i) {
            family.set_row(row, scaled(directions[i], 3), {}, 1);
            const MapEnd end = family.end_at(row, 0);
            if (!(end.error <= max_error)) continue;
            ++interpolated;
            other_kind += end.kind != ends[i].kind;
            double square = 0;
            for (std::size_t k = 0; k < 3; ++k) square += std::pow(end.direction[k] - ends[i].direction[k], 2);
            // Rays in float are less accurate than 1e-5 near the shadow.
            above += ends[i].reaches_sky() && std::sqrt(square) > end.error + 2e-5;
        }
        EXPECT_GT(double(interpolated), 0.98 * double(ends.size()));
        EXPECT_LE(other_kind, ends.size() / 1000);
        EXPECT_LT(double(above), 0.02 * double(interpolated)) << "the estimate must bound nearly all errors";
    }
}

// The pictures of both maps differ where their filters do: the footprint of a pixel is not estimated along the same
// axes.
TEST(OrbitFamily, GivesThePictureOfTheMapOfDirections) {
    for (const char* scene : {"galaxy.toml", "hole.toml", "wormhole.toml"}) {
        const Plan plan = plan_of(scene);
        SkyMap family = new_sky_map(plan), map = DirectionMap();
        ASSERT_TRUE(std::holds_alternative<OrbitFamily>(family)) << scene;
        const MapPicture picture = picture_from_map(plan, family), expected = picture_from_map(plan, map);
        EXPECT_LT(picture.traced, expected.traced / 3) << scene;
        double difference = 0;
        for (std::size_t i = 0; i < expected.rgb.size(); ++i)
            difference += std::abs(double(expected.rgb[i]) - double(picture.rgb[i]));
        EXPECT_LT(difference / double(expected.rgb.size()), 2) << scene;
    }
}

TEST(OrbitFamily, DoesNotServeOtherSpacesAndCameras) {
    EXPECT_FALSE(OrbitFamily::contains_rays_of(plan_of("kerr.toml")));
    EXPECT_FALSE(OrbitFamily::contains_rays_of(plan_of("mirage.toml")));
    EXPECT_FALSE(OrbitFamily::contains_rays_of(plan_of("hole.toml", {"camera.velocity=[0, 0.1, 0]"})));
}

}  // namespace
}  // namespace kagero::test
