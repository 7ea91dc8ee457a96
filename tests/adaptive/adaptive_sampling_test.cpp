// Tests adaptively sampled pictures against pictures in which the rays of all pixels are traced.
#include "adaptive/displacement.h"
#include "adaptive/sample_tile.h"
#include "adaptive/write_ends.h"
#include "plan/sampling.h"
#include "rays/end_distance.h"
#include "render/render.h"
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <random>

namespace kagero::test {
namespace {

constexpr double bound = 0.25;  // the default of film.max_interpolation_error

/// The ends of the rays of all pixels of a picture, row by row.
struct Ends {
    std::uint32_t width, height;
    std::vector<RayEnd> ends;
    std::vector<std::uint8_t> traced;
    std::uint64_t rays = 0;

    const RayEnd& at(std::uint32_t x, std::uint32_t y) const { return ends[std::size_t{y} * width + x]; }
};

/// Traces all rays of a picture.
Ends all_ends(const Plan& plan) {
    const Tile& window = plan.view.window;
    Ends result{window.x1, window.y1, {}, {}, 0};
    RayList list;
    if (!plan.job().camera) list_rays(plan, window, list);
    Counters counters{};
    trace_tile(*plan.run.kernel, plan.job(), window, list, result.ends, counters);
    return result;
}

/// Samples all tiles of a picture adaptively.
Ends adaptive_ends(const Plan& plan) {
    const Tile& window = plan.view.window;
    const std::size_t pixels = std::size_t{window.x1} * window.y1;
    Ends result{window.x1, window.y1, std::vector<RayEnd>(pixels), std::vector<std::uint8_t>(pixels), 0};
    AdaptiveSamples samples;
    Counters counters{};
    for (std::uint32_t y = 0; y < window.y1; y += adaptive_tile_edge)
        for (std::uint32_t x = 0; x < window.x1; x += adaptive_tile_edge) {
            const Tile tile{x, y, std::min(x + adaptive_tile_edge, window.x1),
                            std::min(y + adaptive_tile_edge, window.y1)};
            TracedRays rays;
            sample_tile(plan, plan.job(), tile, bound, rays, samples, counters, {});
            write_ends(tile, rays);
            result.rays += samples.nodes.ends().size();
            std::size_t i = 0;
            for (std::uint32_t row = tile.y0; row < tile.y1; ++row)
                for (std::uint32_t column = tile.x0; column < tile.x1; ++column, ++i) {
                    result.ends[std::size_t{row} * window.x1 + column] = rays.ends[i];
                    result.traced[std::size_t{row} * window.x1 + column] = rays.traced[i];
                }
        }
    return result;
}

/// Returns the part of an end that is seen: the direction on the sky, or the position.
Double3 seen(const Plan& plan, const RayEnd& end) {
    if (!is_seen_by_direction(plan, end)) return {end.q[0], end.q[1], end.q[2]};
    return sky_view(plan.scene->sources.skies, end).direction;
}

/// Returns the derivatives of the traced ends at a pixel, from those neighbours that end alike; 0 without any.
EndDerivatives derivatives_at(const Plan& plan, const Ends& full, std::uint32_t x, std::uint32_t y) {
    const RayEnd& here = full.at(x, y);
    const auto difference = [&](std::uint32_t nx, std::uint32_t ny) {
        if (nx >= full.width || ny >= full.height || !same_status_and_object(here, full.at(nx, ny))) return Double3{};
        return subtract(seen(plan, full.at(nx, ny)), seen(plan, here));
    };
    const auto greater = [](const Double3& a, const Double3& b) { return length(a) > length(b) ? a : b; };
    return {greater(difference(x + 1, y), difference(x - 1, y)), greater(difference(x, y + 1), difference(x, y - 1))};
}

/// Comparison of an adaptive picture with the full one.
struct Comparison {
    std::uint64_t pixels = 0, flips = 0, above_twice_the_bound = 0;
    double greatest_error = 0, traced_share = 0;
};

Comparison compare(const Plan& plan) {
    const Ends full = all_ends(plan), adaptive = adaptive_ends(plan);
    Comparison result;
    result.pixels = full.ends.size();
    std::uint64_t traced = 0;
    for (std::uint32_t y = 0; y < full.height; ++y)
        for (std::uint32_t x = 0; x < full.width; ++x) {
            const RayEnd &expected = full.at(x, y), &actual = adaptive.at(x, y);
            traced += adaptive.traced[std::size_t{y} * full.width + x];
            if (!same_status_and_object(expected, actual)) {
                ++result.flips;
                continue;
            }
            if (!has_visible_end(expected)) continue;
            const double error = displacement_in_pixels(derivatives_at(plan, full, x, y),
                                                        subtract(seen(plan, actual), seen(plan, expected)),
                                                        pixel_size_at(plan, expected));
            result.greatest_error = std::max(result.greatest_error, error);
            result.above_twice_the_bound += error > 2 * bound;
        }
    result.traced_share = double(traced) / double(result.pixels);
    return result;
}

/// Overrides of all pictures of these tests.
Overrides with_camera(const Overrides& camera) {
    Overrides overrides{"film.size=[192,128]", "film.spp=1", "film.sampling=adaptive", "film.layers=[\"color\"]"};
    overrides.insert(overrides.end(), camera.begin(), camera.end());
    return overrides;
}

/// Returns a camera near that of a scene, which looks nearly in the same direction.
Overrides random_camera(const SceneDescription& scene, std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(-1, 1);
    const Double3 &from = scene.camera.position, &to = scene.camera.look_at;
    const double distance = length(subtract(to, from));
    const auto moved = [&](const Double3& q, double scale) {
        std::string text = "[";
        for (std::size_t k = 0; k < 3; ++k)
            text += (k ? "," : "") + std::to_string(q[k] + scale * distance * uniform(random));
        return text + "]";
    };
    return {"camera.position=" + moved(from, 0.1), "camera.look_at=" + moved(to, 0.3),
            "camera.fov=" + std::to_string(60 + 30 * uniform(random))};
}

/// Compares the pictures of one camera. Share of the pixels with an error of more than twice the bound: at most 0.1 %.
/// Pixels with another object or status: at most 1e-4. Returns the share of the pixels that are traced; nothing if the
/// scene refuses the camera.
std::optional<double> expect_agreement(const char* scene, const Overrides& camera, const std::string& isa) {
    SCOPED_TRACE(testing::Message() << isa << ", " << scene << " " << testing::PrintToString(camera));
    Options options;
    options.isa = isa;
    std::unique_ptr<Plan> plan;
    try {
        plan = plan_of_file(scene_file(scene), with_camera(camera), options);
    } catch (const InputError&) {
        return {};
    }
    EXPECT_GT(plan->run.interpolation_bound, 0);
    const Comparison result = compare(*plan);
    EXPECT_LE(double(result.flips), 1e-4 * double(result.pixels));
    EXPECT_LE(double(result.above_twice_the_bound), 1e-3 * double(result.pixels)) << result.greatest_error;
    return result.traced_share;
}

/// A scene, and the greatest share of its pixels that may be traced at the size of this test.
struct SceneCase {
    const char* scene;
    double greatest_share;
};
const SceneCase scene_cases[] = {{"hole.toml", 0.3},     {"wormhole.toml", 0.4}, {"room.toml", 0.6},
                                 {"kerr.toml", 0.6},     {"mirage.toml", 0.8},   {"shimmer.toml", 1},
                                 {"luneburg.toml", 0.9}, {"galaxy.toml", 0.3}};

TEST(AdaptiveSampling, EqualsTheFullPictureWithinItsBound) {
    for (const auto& [scene, greatest_share] : scene_cases) {
        const auto share = expect_agreement(scene, {}, "auto");
        ASSERT_TRUE(share) << scene;
        EXPECT_LE(*share, greatest_share) << scene;
    }
}

TEST(AdaptiveSampling, EqualsTheFullPictureOnEveryInstructionSet) {
    for (const std::string& isa : supported_isas())
        for (const char* scene : {"hole.toml", "room.toml"}) EXPECT_TRUE(expect_agreement(scene, {}, isa)) << scene;
}

/// Returns the number of cameras per scene, which KAGERO_AUDIT_CAMERAS sets.
int audit_cameras() {
    const char* const stated = std::getenv("KAGERO_AUDIT_CAMERAS");
    return stated ? std::atoi(stated) : 1;
}

/// Returns the scenes of the gallery that are sampled adaptively, in addition to those of scene_cases.
std::vector<std::string> other_adaptive_scenes() {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(KAGERO_SCENES)) {
        const std::string name = entry.path().filename().string();
        const bool is_listed = std::any_of(std::begin(scene_cases), std::end(scene_cases),
                                           [&](const SceneCase& listed) { return listed.scene == name; });
        if (entry.path().extension() != ".toml" || is_listed) continue;
        if (plan_of_file(entry.path().string(), with_camera({}))->run.interpolation_bound > 0) names.push_back(name);
    }
    std::sort(names.begin(), names.end());
    return names;
}

TEST(AdaptiveSampling, EqualsTheFullPictureInTheWholeGallery) {
    const std::vector<std::string> scenes = other_adaptive_scenes();
    EXPECT_GE(scenes.size(), 5u);
    for (const std::string& scene : scenes) EXPECT_TRUE(expect_agreement(scene.c_str(), {}, "auto")) << scene;
}

TEST(AdaptiveSampling, EqualsTheFullPictureForRandomCameras) {
    const int cameras = audit_cameras();
    std::mt19937 random(20);
    for (const auto& [scene, greatest_share] : scene_cases) {
        const SceneDescription description = plan_of_file(scene_file(scene), with_camera({}))->description();
        int compared = 0;
        for (int i = 0; i < 10 * cameras && compared < cameras; ++i)
            compared += expect_agreement(scene, random_camera(description, random), "auto").has_value();
        EXPECT_EQ(compared, cameras) << scene;
    }
}

constexpr const char* thin_objects = R"toml([space]
hamiltonian = "schwarzschild"
rg = 0.3
[camera]
position = [-8, 0.4, 0.3]
look_at = [0, 0, 0]
up = [0, 0, 1]
fov = 50
[film]
size = [320, 200]
sampling = "adaptive"
[[object]]
name = "wire"
shape = "box"
min = [-2, -1.0006, -6]
max = [-1.9988, -1, 6]
color = [1, 1, 1]
[[object]]
name = "far-ball"
shape = "sphere"
center = [12, 2.5, 1]
radius = 0.03
[[object]]
name = "near-ball"
shape = "sphere"
center = [-3, 1.2, -0.8]
radius = 0.02
)toml";

// The wire is 0.0012 wide at a distance of 6, where a pixel is 0.028 wide: most of its pixels show the sky. The balls
// have diameters of about one pixel.
TEST(AdaptiveSampling, LosesNoThinObjects) {
    std::vector<double> angles{0.0, 0.4, 1.1, 2.3};
    std::mt19937 random(21);
    std::uniform_real_distribution<double> uniform(0, 3.1);
    for (int i = 1; i < audit_cameras(); ++i) angles.push_back(uniform(random));
    for (const double angle : angles) {
        const auto plan = plan_of_text(thin_objects, {{"camera.up=[0," + std::to_string(std::sin(angle)) + "," +
                                                       std::to_string(std::cos(angle)) + "]"}});
        const Ends full = all_ends(*plan), adaptive = adaptive_ends(*plan);
        std::uint64_t hits = 0;
        for (std::size_t i = 0; i < full.ends.size(); ++i) {
            EXPECT_TRUE(same_status_and_object(full.ends[i], adaptive.ends[i])) << i << ", angle " << angle;
            hits += full.ends[i].status == Status::hit;
        }
        EXPECT_GT(hits, 3u) << angle;
        EXPECT_LT(adaptive.rays, full.ends.size() / 2);
    }
}

TEST(AdaptiveSampling, DoesNotDependOnCropsAndThreads) {
    const Overrides overrides{"film.size=[200,140]", "film.sampling=adaptive",
                              "film.layers=[\"color\",\"traced\",\"object\"]"};
    const auto plan = plan_of_file(scene_file("room.toml"), overrides);
    Film whole = film_of(*plan);
    const RunReport report = render(*plan, whole);
    EXPECT_GT(report.interpolated_pixels, report.pixels / 4);
    EXPECT_LE(report.interpolation_error.max, bound);
    for (const unsigned threads : {1u, 3u})
        for (const Tile& crop :
             {Tile{0, 0, 200, 140}, Tile{13, 7, 171, 101}, Tile{64, 64, 128, 128}, Tile{70, 50, 71, 51}}) {
            Options options;
            options.threads = threads;
            options.crop = crop;
            const auto part = plan_of_file(scene_file("room.toml"), overrides, options);
            Film film = film_of(*part);
            render(*part, film);
            for (const char* layer : {"color", "traced", "object"})
                for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
                    for (std::uint32_t x = crop.x0; x < crop.x1; ++x)
                        ASSERT_EQ(*film.pixel(layer, x - crop.x0, y - crop.y0), *whole.pixel(layer, x, y))
                            << layer << " " << x << "," << y << ", " << threads << " threads";
        }
}

// A cancelled kernel leaves the ends of its rays undefined, so no end may be examined after it.
TEST(AdaptiveSampling, EndsIfItIsCancelled) {
    for (const char* scene : {"hole.toml", "room.toml"})
        for (int allowed_calls = 0; allowed_calls < 12; ++allowed_calls) {
            const auto plan = plan_of_file(scene_file(scene), with_camera({"integrator.step=0.001"}));
            int calls = 0;
            std::pair<int*, int> limit{&calls, allowed_calls};
            const CancelToken cancel{[](void* user) {
                                         auto& [counter, allowed] = *static_cast<std::pair<int*, int>*>(user);
                                         return ++*counter > allowed;
                                     },
                                     &limit};
            TracedRays rays;
            AdaptiveSamples samples;
            Counters counters{};
            sample_tile(*plan, plan->job(), {0, 0, 64, 64}, bound, rays, samples, counters, cancel);
            EXPECT_GT(calls, allowed_calls) << scene;
        }
}

/// Overrides with which a scene cannot be sampled adaptively, and a part of the reason.
struct RefusedCase {
    const char* scene;
    const char* key;
    const char* reason;
};

TEST(AdaptiveSampling, StatesWhyAPictureIsSampledInFull) {
    const RefusedCase cases[] = {{"hole.toml", "film.spp=4", "film.spp > 1"},
                                 {"hole.toml", "film.layers=[\"color\",\"steps\"]", "the layer steps"},
                                 {"mirror-room.toml", "film.spp=1", "rays continue at surfaces"}};
    for (const auto& [scene, key, reason] : cases) {
        const auto plan =
            plan_of_file(scene_file(scene), {"film.size=[32,32]", "film.sampling=adaptive", "film.spp=1", key});
        EXPECT_EQ(plan->run.interpolation_bound, 0);
        const bool stated = std::any_of(plan->remarks.begin(), plan->remarks.end(), [&](const std::string& remark) {
            return remark.find("sampled in full") != std::string::npos && remark.find(reason) != std::string::npos;
        });
        EXPECT_TRUE(stated) << key;
    }
}

TEST(AdaptiveSampling, SharesAStatedErrorBoundWithTheMethod) {
    const auto plan = plan_of_file(scene_file("hole.toml"),
                                   {"film.size=[32,32]", "film.sampling=adaptive", "integrator.max_pixel_error=0.1"});
    EXPECT_EQ(plan->run.interpolation_bound, 0.05);
    EXPECT_EQ(method_bound_of(plan->description(), plan->run), 0.05);
}

}  // namespace
}  // namespace kagero::test
