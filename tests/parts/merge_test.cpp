// Tests that a picture of parts has the same bytes as a picture that is rendered at once.
#include "geometry/mesh_files.h"
#include "tests/support/hole_scene.h"
#include "tests/support/part_fixture.h"

#include <nlohmann/json.hpp>

namespace kagero::test {
namespace {

std::vector<std::string> gallery() {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(KAGERO_SCENES))
        if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
    std::sort(names.begin(), names.end());
    return names;
}

/// Returns true if a scene can have a layer.
bool accepts(const std::string& scene, const std::string& layer) {
    try {
        plan_of_file(scene_file(scene), {Override("film.layers=[\"" + layer + "\"]")});
        return true;
    } catch (const InputError&) {
        return false;
    }
}

/// Returns the override that selects all layers that a scene can have. Only spacetimes have the layer `time`. Scenes
/// with diffuse surfaces have no estimates of the errors of ray ends.
std::string all_layers_of(const std::string& scene) {
    std::string names;
    for (const LayerInfo& layer : all_layers())
        if (accepts(scene, layer.name)) append_to_list(names, '"' + layer.name + '"');
    return "film.layers=[" + names + "]";
}

class Gallery : public PartTest, public testing::WithParamInterface<std::string> {
protected:
    /// Expects that the scene in 3 and 7 parts is the same picture, and that its choices can be restored without a
    /// trial.
    void expect_same_picture(const Overrides& overrides) const {
        Options options;
        options.energy_error = true;
        options.threads = 2;
        const Plan untuned = *plan_of_file(scene_file(GetParam() + ".toml"), overrides, options);
        const Plan plan = tune(untuned, options, Purpose::picture);
        const std::string whole = render_at_once(plan);
        ASSERT_FALSE(whole.empty());
        const Plan restored = with_choices(untuned, choices_of(plan), "the test");
        EXPECT_EQ(choices_of(restored), choices_of(plan));
        EXPECT_EQ(plan_metadata(restored), plan_metadata(plan));
        for (const std::uint32_t count : {3u, 7u})
            EXPECT_TRUE(merge_to_file(render_parts(restored, options, count)) == whole) << count << " parts";
    }
};

/// Returns an override with the scene's number of rays per pixel, but at most four, so that the tests take seconds.
Override few_samples_of(const std::string& scene) {
    const std::uint32_t spp = load_scene(scene_file(scene + ".toml"), {}, catalogue("auto")).film.spp;
    return Override("film.spp=" + std::to_string(std::min(spp, 4u)));
}

TEST_P(Gallery, IsTheSamePictureInParts) { expect_same_picture({"film.size=[160,110]", few_samples_of(GetParam())}); }

TEST_F(PartTest, MergedPictureHasTheToneOfTheScene) {
    Options options;
    const Plan plan = *plan_of_file(scene_file("kerr.toml"), {"film.size=[48,32]", "film.exposure=0.5"}, options);
    const MergedPicture merged = merge_parts(render_parts(plan, options, 2), Missing::refused);
    EXPECT_EQ(merged.film.tone().exposure, 0.5);
    EXPECT_EQ(merged.film.tone().curve, ToneCurve::filmic);
}

// The film has an odd size, so that blocks of 2 × 2 pixels extend beyond it, and only six tiles, so that one of seven
// parts is empty.
TEST_P(Gallery, IsTheSameInAllLayers) {
    expect_same_picture({"film.size=[75,51]", few_samples_of(GetParam()), Override(all_layers_of(GetParam() + ".toml")),
                         "integrator.max_steps=1000"});
}

INSTANTIATE_TEST_SUITE_P(Scenes, Gallery, testing::ValuesIn(gallery()), [](const auto& scene) {
    std::string name = scene.param;
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
});

class Merge : public HoleTest {};

// Each line contains options that determine the tiles, the precision, or the rays of a pixel.
TEST_F(Merge, HasTheBytesOfASingleRender) {
    for (const std::string options :
         {"--size 130x70 --crop 33,5,101,64 --layers color,footprint,magnification,occupancy",
          "--size 130x70 --schedule scanline --layers color,status,occupancy", "--size 20x20 --spp 70 --seed 3",
          "--size 200x150 --precision float", "--size 130x70 -D integrator.max_pixel_error=0.2 -D space.rg=0.2"}) {
        ASSERT_EQ(run("render hole.toml --quiet --threads 2 -o whole.exr " + options).status, 0) << options;
        std::string parts;
        for (const std::string number : {"2", "1", "3"}) {
            const Outcome outcome = run("render hole.toml --threads " + number + " --part " + number + "/3 " + options);
            ASSERT_EQ(outcome.status, 0) << outcome.err;
            parts += " hole-" + number + "-of-3.part";
        }
        const Outcome outcome = run("merge" + parts + " -o merged.exr");
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_TRUE(read("merged.exr") == read("whole.exr")) << options;
        ASSERT_EQ(run("merge" + parts + " --quiet -o merged.png").status, 0);
        ASSERT_EQ(run("render hole.toml --quiet -o whole.png " + options).status, 0);
        EXPECT_TRUE(read("merged.png") == read("whole.png")) << options;
    }
}

TEST_F(Merge, ReportsTheCountsOfASingleRender) {
    for (const std::string sampling : {"full", "adaptive"}) {
        SCOPED_TRACE(sampling);
        const std::string render = "render hole.toml --quiet --size 100x70 --sampling " + sampling + " ";
        const Outcome whole = run(render + "-o whole.exr --json");
        ASSERT_EQ(run(render + "--part 1/2 -o 1.part").status + run(render + "--part 2/2 -o 2.part").status, 0);
        // The value of --json is optional, so that a part can follow it.
        const Outcome merged = run("merge --quiet -o merged.exr --json 1.part 2.part");
        ASSERT_EQ(merged.status, 0) << merged.err;
        const auto expected = nlohmann::json::parse(whole.out), found = nlohmann::json::parse(merged.out);
        for (const char* key : {"rays", "steps", "gradients", "queries", "lane_occupancy", "status", "energy_error",
                                "isa", "precision", "strategy", "width", "height", "interrupted", "traced_share"})
            EXPECT_EQ(found.at(key), expected.at(key)) << key;
        EXPECT_EQ(found.at("missing_tiles"), 0);
        EXPECT_EQ(found.value("interpolation_error", nlohmann::json()),
                  expected.value("interpolation_error", nlohmann::json()));
    }
}

TEST(ReferencedFiles, AreTheBuffersOfGltf) {
    const auto directory = std::filesystem::temp_directory_path() / ("kagero-gltf-" + std::to_string(::getpid()));
    std::filesystem::create_directories(directory);
    std::ofstream(directory / "a b.bin") << "1234";
    const std::string path = (directory / "mesh.gltf").string();
    std::ofstream(path) << R"({"asset":{"version":"2.0"},"scenes":[{}],"buffers":[{"byteLength":4,"uri":"a%20b.bin"},)"
                        << R"({"byteLength":3,"uri":"data:application/octet-stream;base64,AAAA"}]})";
    EXPECT_EQ(files_of_mesh(path), std::vector<std::string>{(directory / "a b.bin").string()});
    EXPECT_TRUE(files_of_mesh((directory / "a b.bin").string()).empty());
    std::filesystem::remove_all(directory);
}

}  // namespace
}  // namespace kagero::test
