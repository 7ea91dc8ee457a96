// Requests of the page: legal keys and values, and the refusal of all others.
#include "view/view_state.h"
#include "error.h"
#include "plan/scene.h"
#include "scene/load/load.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace kagero::test {
namespace {

SceneDescription scene_named(const std::string& name) {
    return load_scene(std::string(KAGERO_SCENES) + "/" + name, {}, catalogue("auto"));
}

std::string message_of(const std::string& json, const SceneDescription& scene) {
    try {
        parse_view_state(json, scene);
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

TEST(ViewState, ContainsTheKeysAsOverrides) {
    const ViewState state = parse_view_state(
        R"({"tab": "a1", "keys": {"space.rg": 0.1, "camera.position": [1, 2, 3], "film.tone": "filmic"},
            "quality": "moving", "width": 64, "height": 48, "layer": "steps"})",
        scene_named("room.toml"));
    EXPECT_EQ(state.tab, "a1");
    EXPECT_EQ(state.quality, Quality::moving);
    std::vector<std::string> texts;
    for (const Override& each : state.overrides()) texts.push_back(each.text);
    const std::vector<std::string> expected{"space.rg=0.1",         "camera.position=[1, 2, 3]",
                                            "film.tone=\"filmic\"", "film.size=[64,48]",
                                            "film.spp=1",           "film.layers=[\"steps\"]"};
    EXPECT_EQ(texts, expected);
}

// Only an orthographic camera has a height.
TEST(ViewState, ChangesTheHeightOfAnOrthographicCamera) {
    SceneDescription scene = scene_named("room.toml");
    const std::string request = R"({"tab": "a", "keys": {"camera.height": 0.5}})";
    EXPECT_NE(message_of(request, scene).find("camera.height"), std::string::npos);
    scene.camera.type = CameraType::orthographic;
    EXPECT_EQ(message_of(request, scene), "");
    EXPECT_EQ(parse_view_state(request, scene).overrides().front().text, "camera.height=0.5");
}

// A page must not be able to make the server read a file.
TEST(ViewState, HasNoKeyThatNamesAFile) {
    for (const char* name : {"room.toml", "formula-mirage.toml", "galaxy.toml"}) {
        const SceneDescription scene = scene_named(name);
        for (const char* key : {"sky.texture",
                                "object.ground.file",
                                "object.room.texture",
                                "sky.far.texture",
                                "animation.set.x",
                                "film.size",
                                "film.spp",
                                "film.layers",
                                "object",
                                "sky",
                                "space",
                                "space.hamiltonian",
                                "camera",
                                "integrator.method",
                                "medium.glass.n0",
                                "space.let.a.b",
                                "space.let.",
                                "space.let.a b",
                                "space.let.\"x\"",
                                ""}) {
            EXPECT_FALSE(is_live_key(scene, key)) << name << ": " << key;
            EXPECT_NE(message_of(nlohmann::json{{"keys", {{key, "/etc/passwd"}}}}.dump(), scene), "")
                << name << ": " << key;
        }
    }
}

TEST(ViewState, HasTheParametersOfTheSpace) {
    const SceneDescription room = scene_named("room.toml"), formula = scene_named("formula-mirage.toml");
    EXPECT_TRUE(is_live_key(room, "space.rg"));
    EXPECT_FALSE(is_live_key(room, "space.mass"));
    EXPECT_FALSE(is_live_key(room, "space.H"));
    EXPECT_TRUE(is_live_key(formula, "space.H"));
    EXPECT_TRUE(is_live_key(formula, "space.let.n"));
    EXPECT_TRUE(is_live_key(formula, "space.constants.a"));
}

TEST(ViewState, RefusesInvalidValues) {
    const SceneDescription scene = scene_named("room.toml");
    for (const char* json :
         {"", "[]", "{", "\"text\"", R"({"keys": []})", R"({"keys": {"space.rg": null}})",
          R"({"keys": {"space.rg": [1, 2]}})", R"({"keys": {"space.rg": {"a": 1}}})",
          R"({"keys": {"camera.position": [1, 2, "x"]}})", R"({"layer": "nothing"})", R"({"quality": "best"})",
          R"({"width": 0})", R"({"width": -1})", R"({"width": 5000})", R"({"width": 4096, "height": 4096})",
          R"({"width": 1.5})", R"({"spp": 65})", R"({"tab": "../x"})", R"({"tab": 5})"})
        EXPECT_NE(message_of(json, scene), "") << json;
    EXPECT_NE(message_of(R"({"keys": {"film.tone": ")" + std::string(5000, 'x') + "\"}}", scene), "");
    EXPECT_NE(message_of(std::string(20000, '['), scene), "");
}

}  // namespace
}  // namespace kagero::test
