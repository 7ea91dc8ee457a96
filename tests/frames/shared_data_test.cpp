// Frames of one animation share images and meshes that do not change, and the library opens the shutter.
#include "tests/support/part_fixture.h"

#include "frames/frame_plans.h"
#include "scene/load/load.h"

#include <kagero/scene.h>

namespace kagero::test {
namespace {

/// A ball moves past a mesh that stays, both with images.
constexpr const char* moving_ball = R"([space]
hamiltonian = "flat"
[camera]
position = [0, -10, 0]
look_at = [0, 0, 0]
up = [0, 0, 1]
[film]
size = [24, 16]
spp = 4
[sky]
texture = "image.png"
[[object]]
name = "ball"
shape = "sphere"
center = [0, 0, 0]
radius = 1
texture = "image.png"
[[object]]
name = "plate"
shape = "mesh"
file = "plate.obj"
checker = [4, 4]
[animation]
frames = 4
[animation.set]
"object.ball.center" = ["0.5*frame - 1", "0", "0"]
)";

class SharedData : public PartTest {
protected:
    void SetUp() override {
        PartTest::SetUp();
        write("plate.obj", "v -1 2 -2\nv 1 2 -2\nv 0 2 2\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
        write("scene.toml", moving_ball);
        write("image.toml",
              "[space]\nhamiltonian = \"flat\"\n[camera]\nposition = [0, 0, 0]\nlook_at = [1, 0, 0]\n"
              "[film]\nsize = [32, 16]\n[sky]\nchecker = true\n");
        ASSERT_EQ(run("render image.toml --quiet -o image.png").status, 0);
        options_.threads = 1;
        options_.energy_error = true;
    }
    SceneDescription scene(const Overrides& overrides = {}) const {
        return load_scene(path_of("scene.toml"), overrides, catalogue("auto"));
    }

    Options options_;
};

// The files are damaged after the first frame, so that a frame that reads one of them again fails.
TEST_F(SharedData, IsLoadedOnceAlthoughAnObjectMoves) {
    std::vector<std::string> expected;
    for (int frame = 1; frame < 4; ++frame) {
        FramePlans separate(scene(), options_, {});
        expected.push_back(render_at_once(separate.plan(frame)));
    }
    FramePlans plans(scene(), options_, {});
    write("image.png", "no image");
    write("plate.obj", "no mesh");
    const Paints& first = *plans.first().scene->paints;
    for (int frame = 1; frame < 4; ++frame) {
        const Plan plan = plans.plan(frame);
        EXPECT_NE(plan.scene->geometry, plans.first().scene->geometry) << "the ball has not moved";
        EXPECT_EQ(plan.scene->paints->object(0).paints[0].image, first.object(0).paints[0].image);
        EXPECT_EQ(plan.scene->paints->sky(false).paint.coarser, first.sky(false).paint.coarser);
        EXPECT_EQ(render_at_once(plan), expected[static_cast<std::size_t>(frame - 1)]) << "frame " << frame;
    }
    EXPECT_NE(expected[0], expected[1]);
}

TEST_F(SharedData, IsLoadedAgainIfItChanges) {
    const Overrides moving_plate{{"animation.set.\"object.plate.translate\"=[\"0.2*frame\", \"0\", \"0\"]"}};
    FramePlans plans(scene(moving_plate), options_, {});
    EXPECT_NE(render_at_once(plans.plan(1)), render_at_once(plans.plan(2)));
    write("plate.obj", "no mesh");
    EXPECT_THROW(plans.plan(3), InputError);
}

// The picture of the command line is the reference.
TEST_F(SharedData, IsUsedForTheShutterOfTheLibrary) {
    ASSERT_EQ(run("render scene.toml --quiet -D camera.shutter=0.5 -o expected.exr").status, 0);
    ASSERT_EQ(run("render scene.toml --quiet -o closed.exr").status, 0);
    const LoadedScene open = load(path_of("scene.toml"), {"camera.shutter=0.5"});
    for (const unsigned threads : {1u, 2u}) {  // the second picture uses the plans of the first one
        RunOptions options;
        options.threads = threads;
        open.render(options).write(path_of("open.exr"));
        EXPECT_TRUE(read("open.exr") == read("expected.exr")) << threads << " threads";
    }
    EXPECT_FALSE(read("open.exr") == read("closed.exr"));
}

}  // namespace
}  // namespace kagero::test
