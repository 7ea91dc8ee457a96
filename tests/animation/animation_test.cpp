// Tests of the table [animation]: its keys, the values of expressions, and its messages.
#include "animation/animation.h"
#include "plan/scene.h"
#include "scene/load/load.h"
#include "scene/print.h"

#include <gtest/gtest.h>

namespace kagero::test {
namespace {

const std::string moving = R"([space]
hamiltonian = "flat"
[camera]
position = [0, -5, 0]
look_at = [0, 0, 0]
up = [0, 0, 1]
[film]
size = [16, 8]
[[object]]
name = "left ball"
shape = "sphere"
center = [0, 0, 0]
radius = 1
[animation]
frames = 9
fps = 4
[animation.set]
"camera.fov" = "40 + frame"
"camera.position" = ["u", "-5 - w", 2]
'object."left ball".radius' = "0.5 + s"
"film.seed" = "3*frame"
)";

SceneDescription at_frame(double frame, const std::vector<Override>& overrides = {}, const std::string& text = moving) {
    return load_scene_text(text, "a.toml", overrides, catalogue("auto"), SceneUse::picture, frame);
}

std::string message_at(double frame, const std::vector<Override>& overrides, const std::string& text = moving) {
    try {
        at_frame(frame, overrides, text);
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

TEST(Animation, SetsKeysToTheValuesOfAFrame) {
    for (const double frame : {0.0, 2.0, 2.5, 8.0}) {
        // film.seed cannot have the value 7.5.
        const std::string text = frame == 2.5 ? moving.substr(0, moving.find("\"film")) : moving;
        const SceneDescription scene = at_frame(frame, {}, text);
        EXPECT_EQ(scene.camera.fov, 40 + frame);
        EXPECT_EQ(scene.camera.position, (Double3{frame / 9, -5 - frame / 8, 2}));
        EXPECT_EQ(scene.objects[0].radius, 0.5 + frame / 4);
        EXPECT_EQ(scene.film.seed, frame == 2.5 ? 0 : 3 * frame);
        EXPECT_EQ(scene.animation->frame, frame);
    }
}

TEST(Animation, OfASingleFrameHasNoEnd) {
    const SceneDescription scene = at_frame(0, {"animation.frames=1"});
    EXPECT_EQ(scene.camera.position, (Double3{0, -5, 2}));
}

TEST(Animation, IsFixedByOverridesOfTheSameKey) {
    const SceneDescription scene =
        at_frame(3, {"camera.fov=20", "animation.set.\"camera.position\"=[\"2*u\",\"-7\",0]"});
    EXPECT_EQ(scene.camera.fov, 20);
    EXPECT_EQ(scene.camera.position, (Double3{2 * (3.0 / 9), -7, 0}));
    EXPECT_EQ(scene.animation->keys.size(), 3u);
}

TEST(Animation, IsPrintedAndReadAgain) {
    const SceneDescription scene = at_frame(0);
    const std::string text = print_scene(scene);
    EXPECT_NE(text.find("\"camera.position\" = [\"u\", \"-5 - w\", 2]"), std::string::npos) << text;
    for (const double frame : {0.0, 5.0}) {
        const SceneDescription again = at_frame(frame, {}, text), direct = at_frame(frame);
        EXPECT_EQ(print_scene(again), print_scene(direct));
    }
}

TEST(Animation, NamesTheFrameAndThePositionOfAnIllegalValue) {
    const std::string line =
        std::to_string(std::count(moving.begin(), moving.begin() + long(moving.find("\"40 +")), '\n') + 1);
    std::string text = moving;
    text.replace(text.find("40 + frame"), 10, "170+ frame");
    const std::string message = message_at(10, {"animation.frames=20"}, text);
    EXPECT_TRUE(message.starts_with("a.toml:" + line + ":")) << message;
    EXPECT_NE(message.find("camera.fov = 180 is out of range"), std::string::npos) << message;
    EXPECT_NE(message.find("(in frame 10 of the animation)"), std::string::npos) << message;
    EXPECT_EQ(message_at(9, {"animation.frames=20"}, text), "");
}

TEST(Animation, RefusesWhatNoFrameCanSet) {
    const auto expect = [](const std::string& value, const std::string& expected) {
        const std::string message = message_at(0, {"animation.set." + value});
        EXPECT_NE(message.find(expected), std::string::npos) << value << ": " << message;
    };
    expect("\"film.size\"=[1, 2]", "all frames have the same size");
    expect("\"animation.fps\"=2", "an animation cannot change itself");
    expect("camera.fov=2", "write the whole path as one quoted key");
    expect("\"camera.fovv\"=\"2\"", "unknown key camera.fovv; did you mean \"fov\"?");
    expect("\"camera.fov\"=true", "a number, or an expression of frame, u, w and s");
    expect("\"camera.fov\"=\"40*x\"", "it may depend only on frame, u, w and s");
    expect("\"camera.fov\"=\"40*fram\"", "did you mean frame? Legal names: pi, frame, u, w, s, sqrt, ");
    expect("\"camera.fov\"=\"1/frame\"", "is not a finite number");
    expect("\"camera.fov\"=\"log(frame - 1)\"", "is not a finite number");
    expect("\"camera.fov\"=\"2 +\"", "the formula ends where");
    expect("\"camera . fov\"=\"2\"", "are the same key");
    expect("\"film.spp\"=\"1.5\"", "film.spp = 1.5 is not legal: it must be a whole number");
    expect("\"object.moon.radius\"=\"1\"", "there is no object \"moon\"");
    EXPECT_NE(message_at(0, {"animation.frames=0"}).find("1 <= value <= 2147483648"), std::string::npos);
    EXPECT_NE(message_at(0, {"animation.frame=7"}).find("unknown key animation.frame"), std::string::npos);
    EXPECT_NE(message_at(0, {"animation.fps=0"}).find("0 < value"), std::string::npos);
}

}  // namespace
}  // namespace kagero::test
