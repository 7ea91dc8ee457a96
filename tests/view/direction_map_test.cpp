// The map over all directions: its geometry, its error estimate, and pictures that are made from it.
#include "view/sky/direction_map.h"
#include "accuracy/end_errors.h"
#include "scene/load/load.h"
#include "scene/sky_only.h"
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

std::vector<Double3> random_directions(std::size_t count) {
    std::mt19937 generator(1);
    std::normal_distribution<double> normal;
    std::vector<Double3> directions(count);
    for (Double3& direction : directions)
        for (double& component : direction) component = normal(generator);
    return directions;
}

TEST(DirectionMap, FindsThePointOfADirection) {
    for (const Double3& d : random_directions(10000)) {
        const CubePoint point = cube_point(d);
        ASSERT_LT(point.block, map_block_count);
        const Double3 found = direction_of(point.block, point.s, point.t);
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(found[k], d[k] * point.inverse_depth, 1e-6);
    }
}

TEST(DirectionMap, FindsThePointsOfARow) {
    std::size_t same = 0, all = 0;
    for (const Double3& first : random_directions(100)) {
        const Double3 step{0.004, -0.003, 0.002};
        CubeRow row;
        row.set(first, step, 500);
        for (std::uint32_t i = 0; i < 500; ++i) {
            Double3 direction;
            for (std::size_t k = 0; k < 3; ++k) direction[k] = first[k] + i * step[k];
            const CubePoint expected = cube_point(direction), point = row[i];
            const Double3 found = direction_of(point.block, point.s, point.t);
            for (std::size_t k = 0; k < 3; ++k)
                EXPECT_NEAR(found[k], direction[k] * point.inverse_depth, 2e-6 * (1 + 3 * point.inverse_depth));
            same += point.block == expected.block;
            ++all;
        }
    }
    EXPECT_GT(same, all - all / 1000) << "only points at the edges of blocks may differ";
}

TEST(DirectionMap, HasBlocksWithoutGaps) {
    for (const Double3& d :
         {Double3{1, 1, 1}, Double3{-1, 1, -1}, Double3{1, -1, 0}, Double3{0, 0, -1}, Double3{1, 0, 0}})
        EXPECT_LT(cube_point(d).block, map_block_count);
}

// The directions that are interpolated in the middle of cells are compared with traced rays.
TEST(DirectionMap, EstimatesItsError) {
    for (const char* scene : {"galaxy.toml", "wormhole.toml"}) {
        const Plan plan = plan_of(scene);
        constexpr double max_error = 1e-3, width = 0.05;
        DirectionMap map;
        std::vector<std::uint32_t> blocks;
        for (std::uint32_t i = 0; i < map_block_count; i += 7) blocks.push_back(i);
        map.refine(plan, blocks, max_error, width, 0.004);
        std::vector<Double3> directions;
        std::vector<std::array<double, 4>> interpolated;
        for (const std::uint32_t index : blocks) {
            const MapBlock& block = map.block(index);
            for (std::uint32_t cell = 0; cell < block.error.size(); ++cell) {
                const std::uint32_t row = cell / block.cells, column = cell % block.cells,
                                    corner = row * (block.cells + 1) + column;
                if (!(block.error[cell] <= max_error) || !block.corners[corner].reaches_sky()) continue;
                std::array<double, 4> mean{0, 0, 0, block.error[cell]};
                for (const std::uint32_t c : {corner, corner + 1, corner + block.cells + 1, corner + block.cells + 2})
                    for (std::size_t k = 0; k < 3; ++k) mean[k] += 0.25 * block.corners[c].direction[k];
                interpolated.push_back(mean);
                directions.push_back(direction_of(index, (column + 0.5) / block.cells, (row + 0.5) / block.cells));
            }
        }
        std::uint64_t rays = 0, above = 0;
        double seconds = 0;
        const std::vector<SkyEnd> ends = trace_sky_ends(plan, directions, rays, seconds);
        ASSERT_GT(ends.size(), 1000u) << scene;
        EXPECT_EQ(rays, ends.size());
        for (std::size_t i = 0; i < ends.size(); ++i) {
            double square = 0;
            for (std::size_t k = 0; k < 3; ++k) square += std::pow(interpolated[i][k] - ends[i].direction[k], 2);
            above += std::sqrt(square) > interpolated[i][3] + 1e-6;  // rays in float are less accurate than 1e-6
        }
        EXPECT_LT(double(above), 0.02 * double(ends.size())) << scene << ": the estimate must bound nearly all errors";
    }
}

// The pictures of both kinds of map are compared with that of `render`, whose filter differs, so that only means over
// blocks agree.
TEST(DirectionMap, GivesThePictureOfRender) {
    for (const char* scene : {"galaxy.toml", "hole.toml", "wormhole.toml"}) {
        const Plan plan = plan_of(scene);
        ASSERT_TRUE(shows_only_sky(plan.description())) << scene;
        Film film = film_of(plan);
        render_with_errors(plan, film);
        for (SkyMap map : {SkyMap(DirectionMap()), new_sky_map(plan)}) {
            SCOPED_TRACE(std::string(scene) + (map.index() == 0 ? ", map of directions" : ", family of orbits"));
            const MapPicture picture = picture_from_map(plan, map);
            EXPECT_LE(picture.max_error, max_map_error);
            EXPECT_LE(picture.p99_error, picture.max_error);
            const auto expected = display_bytes(film.plane("color"), picture.rgb.size(), film.tone());
            double difference = 0;
            for (std::size_t i = 0; i < expected.size(); ++i)
                difference += std::abs(double(expected[i]) - double(picture.rgb[i]));
            EXPECT_LT(difference / double(expected.size()), 4);
        }
    }
}

TEST(DirectionMap, TracesFewRaysWhenOnlyTheViewTurns) {
    const Plan first = plan_of("galaxy.toml"), turned = plan_of("galaxy.toml", {"camera.look_at=[0, 0.06, 0]"});
    SkyMap map;
    const std::uint64_t of_first = picture_from_map(first, map).traced;
    const MapPicture picture = picture_from_map(turned, map);
    EXPECT_LT(picture.traced, of_first);
    EXPECT_LT(picture.traced, std::uint64_t{320} * 180 / 4);
}

}  // namespace
}  // namespace kagero::test
