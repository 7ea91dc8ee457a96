// Tests of the keys of [film] for displays.
#include "scene/load/load.h"
#include "scene/print.h"
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

namespace kagero::test {
namespace {

const std::string text = R"toml([space]
hamiltonian = "flat"
[camera]
position = [0, 0, 1]
look_at = [0, 0, 0]
[film]
size = [4, 4]
)toml";

SceneDescription load(const std::string& added) {
    return load_scene_text(text + added, "film.toml", {}, catalogue("auto"), SceneUse::picture);
}

TEST(FilmKeys, HaveDefaultsThatLeaveThePictureAsItIs) {
    const SceneDescription scene = load("");
    EXPECT_EQ(scene.film.tone.exposure, 0);
    EXPECT_EQ(scene.film.tone.curve, ToneCurve::clip);
}

TEST(FilmKeys, AreReadAndPrinted) {
    const SceneDescription scene = load("exposure = -0.5\ntone = \"filmic\"\n");
    EXPECT_EQ(scene.film.tone.exposure, -0.5);
    EXPECT_EQ(scene.film.tone.curve, ToneCurve::filmic);
    const std::string printed = print_scene(scene);
    EXPECT_NE(printed.find("\nexposure = -0.5\ntone = \"filmic\"\n"), std::string::npos) << printed;
}

struct WrongKey {
    const char *added, *message;
};

TEST(FilmKeys, WithWrongValuesAreRefused) {
    const WrongKey wrong[] = {
        {"exposure = 65", "film.toml:8:12: film.exposure = 65 is out of range: the legal range is -64 <= value <= 64"},
        {"exposure = -1e9", "film.toml:8:12: film.exposure = -1000000000"},
        {"exposure = nan", "film.toml:8:12: film.exposure"},
        {"exposure = \"2\"", "film.toml:8:12: film.exposure"},
        {"tone = \"flimic\"", "film.toml:8:8: film.tone = \"flimic\""},
        {"tone = \"flimic\"", "did you mean \"filmic\"? Legal names: clip, filmic"},
        {"tone = 2", "film.toml:8:8: film.tone"},
    };
    for (const auto& [added, message] : wrong) {
        try {
            load(added);
            ADD_FAILURE() << added << " was accepted";
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
        }
    }
}

}  // namespace
}  // namespace kagero::test
