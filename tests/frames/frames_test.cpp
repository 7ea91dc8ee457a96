// Tests of `render --frames`: pictures, the manifest, and renders that continue.
#include "tests/support/film_scene.h"

#include <nlohmann/json.hpp>

#include <random>

namespace kagero::test {
namespace {

using nlohmann::json;

class Frames : public FilmTest {};

TEST_F(Frames, HaveTheSameBytesWhateverIsRenderedWithThem) {
    ASSERT_EQ(run("render film.toml --frames 0:9 -o all-%d.exr --threads 2").status, 0);
    ASSERT_EQ(run("render film.toml --frames 7:9 -o some-%d.exr --threads 1").status, 0);
    ASSERT_EQ(run("render film.toml --frames 1:8:3 -o some-%d.exr --threads 3").status, 0);
    ASSERT_EQ(run("render film.toml -o first.exr").status, 0);
    EXPECT_TRUE(read("first.exr") == read("all-0.exr"));
    for (const std::string frame : {"1", "4", "7", "8"})
        EXPECT_TRUE(read("some-" + frame + ".exr") == read("all-" + frame + ".exr")) << frame;
    EXPECT_FALSE(read("all-1.exr") == read("all-2.exr"));
    // The manifest contains the frames of both runs.
    EXPECT_EQ(json::parse(read("some-frames.json"))["frames"].size(), 4u);
}

// A value that is not legal is found before a frame is rendered, also by `check`.
TEST_F(Frames, AreCheckedBeforeTheFirstOne) {
    const std::string wrong = " -D 'animation.set.\"camera.fov\"=\"where((frame - 5)^2, 50, 200)\"'";
    const auto before = files();
    for (const std::string verb : {"render film.toml --frames 0:9 -o a-%d.exr", "check film.toml"}) {
        const Outcome outcome = run(verb + wrong);
        EXPECT_EQ(outcome.status, 2) << outcome.err;
        EXPECT_NE(outcome.err.find("camera.fov = 200 is out of range: the legal range is 0 < value < 180 (in frame 5"),
                  std::string::npos)
            << outcome.err;
        EXPECT_EQ(files(), before);
    }
    EXPECT_EQ(run("render film.toml --frames 0:5 -o a-%d.exr --size 8x8" + wrong).status, 0);
    // While the shutter is open, the last sub-frame is at 8 + 0.5 · 3/4.
    const Outcome outcome = run("check film.toml -D camera.shutter=0.5 -D film.spp=2 "
                                "-D 'animation.set.\"camera.fov\"=\"where(frame - 8.3, 200, 50)\"'");
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_NE(outcome.err.find("(in frame 8.375"), std::string::npos) << outcome.err;
}

TEST_F(Frames, NeedTheOptionFramesIfTheNameHasAPlaceForTheirNumber) {
    const Outcome outcome = run("render film.toml -o a-%03d.png");
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find("only frame 0 is rendered; state --frames, such as --frames 0:9"), std::string::npos)
        << outcome.err;
    EXPECT_EQ(run("render hole.toml --size 8x8 -o a-%03d.png").status, 0);
}

// The frame is the picture of a scene without an animation that states the same values.
TEST_F(Frames, AreThePicturesOfTheirValues) {
    ASSERT_EQ(run("render film.toml --frames 4:5 -o a-%d.png -D integrator.step=0.05").status, 0);
    ASSERT_EQ(run("render hole.toml -o a.png -D integrator.step=0.05 -D space.rg=0.2 -D camera.fov=54").status, 0);
    EXPECT_TRUE(read("a-4.png") == read("a.png"));
}

TEST_F(Frames, OfAStillSceneAreEqual) {
    ASSERT_EQ(run("render hole.toml -D animation.frames=4 --frames 1:4 -o a-%d.exr").status, 0);
    EXPECT_TRUE(read("a-1.exr") == read("a-2.exr"));
    EXPECT_TRUE(read("a-2.exr") == read("a-3.exr"));
}

// A film whose first frame is flat has the method and step that all frames need, and explain states the frames of the
// trial.
TEST_F(Frames, ShareOneChoice) {
    ASSERT_EQ(run("render film.toml --size 200x160 -D 'animation.set.\"space.rg\"=\"0.2*u\"' --frames 0:9 -o a-%d.png "
                  "--json report.json")
                  .status,
              0);
    const json report = json::parse(read("report.json"));
    std::set<std::string> choices;
    for (std::size_t i = 1; i < 9; ++i) {
        const json& frame = report["frames"][i];
        const json step = frame.contains("step") ? frame["step"] : frame["tolerance"];
        choices.insert(frame["integrator"].get<std::string>() + step.dump() + frame["precision"].dump());
        EXPECT_EQ(frame["frame"], i);
        EXPECT_EQ(frame["values"]["space.rg"], 0.2 * (double(i) / 9));
        EXPECT_EQ(frame["rays"], 200 * 160);
    }
    EXPECT_EQ(choices.size(), 1u);
    const Outcome explained = run("explain film.toml");
    EXPECT_NE(explained.out.find("by trials of frames 0, 4 and 8"), std::string::npos) << explained.out;
}

TEST_F(Frames, AreKeptIfTheyAreComplete) {
    const std::string render = "render film.toml --resume -o a-%d.exr --frames ";
    ASSERT_EQ(run(render + "0:3").status, 0);
    const auto written = std::filesystem::last_write_time(directory_ / "a-1.exr");
    std::filesystem::remove(directory_ / "a-0.exr");
    write("a-2.exr", "damaged");
    const Outcome outcome = run(render + "0:5 --json report.json");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("1 of them were complete"), std::string::npos) << outcome.err;
    EXPECT_EQ(json::parse(read("report.json"))["frames_rendered"], 4);
    EXPECT_EQ(std::filesystem::last_write_time(directory_ / "a-1.exr"), written);
    ASSERT_EQ(run("render film.toml -o b-%d.exr --frames 0:5").status, 0);
    for (const std::string frame : {"0", "1", "2", "3", "4"})
        EXPECT_TRUE(read("a-" + frame + ".exr") == read("b-" + frame + ".exr")) << frame;
    const Outcome other = run(render + "0:5 --seed 3");
    EXPECT_EQ(other.status, 2);
    EXPECT_NE(other.err.find("the frames belong to another render: the list of overrides is"), std::string::npos)
        << other.err;
    write("a-frames.json", "{}");
    EXPECT_NE(run(render + "0:5").err.find("a-frames.json is not a manifest of frames"), std::string::npos);
}

TEST_F(Frames, ContinueAfterKills) {
    const std::string render =
        "render film.toml --size 256x160 --integrator gauss8 --step 0.01 --frames 0:6 --threads 2 ";
    ASSERT_EQ(run(render + "--quiet -o whole-%d.exr").status, 0);
    // The process is killed a random time after it began a journal.
    write("until.sh",
          "export KAGERO_JOURNAL_INTERVAL=0.02; \"$@\" & until ls a-*.journal >/dev/null 2>&1 || ! kill -0 $! "
          "2>/dev/null; do sleep 0.02; done; "
          "sleep $SHARE; kill -KILL $! 2>/dev/null; wait $!\n");
    std::mt19937 random(1);
    std::uniform_real_distribution<double> seconds(0.3, 1.5);
    int continued = 0;
    for (int i = 0; i < 4; ++i) {
        const Outcome outcome =
            run(render + "--resume -o a-%d.exr", "SHARE=" + std::to_string(seconds(random)) + " sh until.sh");
        continued += outcome.err.find("continues frame") != std::string::npos;
    }
    const Outcome last = run(render + "--resume -o a-%d.exr --threads 1");
    ASSERT_EQ(last.status, 0) << last.err;
    continued += last.err.find("were complete") != std::string::npos;
    EXPECT_GT(continued, 0) << "no run continued";
    for (const std::string frame : {"0", "1", "2", "3", "4", "5"}) {
        EXPECT_TRUE(read("a-" + frame + ".exr") == read("whole-" + frame + ".exr")) << frame;
        EXPECT_FALSE(exists("a-" + frame + ".exr.journal"));
    }
}

TEST_F(Frames, RefuseOptionsThatExcludeThem) {
    const auto expect = [&](const std::string& arguments, const std::string& expected) {
        const Outcome outcome = run("render " + arguments);
        EXPECT_EQ(outcome.status, 2) << arguments;
        EXPECT_NE(outcome.err.find(expected), std::string::npos) << arguments << ": " << outcome.err;
    };
    expect("hole.toml --frames 0:2", "is not animated; add the table [animation]");
    expect("film.toml --frames 0:2 -o a.exr", "has no place for the number of the frame");
    expect("film.toml --frames 0:2 --part 1/2", "--frames A+I-1:B:N");
    expect("film.toml --frames 0:2 --pixel 1,1", "leave --frames out");
    expect("film.toml --frames 0:10", "frames 0 to 8");
    expect("film.toml --frames 0:9 -D 'animation.set.\"camera.fov\"=\"50-10*frame\"' -o a-%d.exr", "(in frame 5 of");
    expect("film.toml --frames 0:2147483649 -o a-%d.exr", "'0:2147483649' is beyond 2147483648");
    expect(
        "film.toml -D animation.frames=40 --frames 0:40 -D 'animation.set.\"camera.fov\"=\"50+0/(frame-17)\"' "
        "-o b-%d.exr",
        "(in frame 17 of");
    EXPECT_FALSE(exists("b-17.exr"));
    expect("film.toml --frames 0:2 -o nowhere/a-%d.exr", "the directory 'nowhere' does not exist");
}

// The ball is white, and the sky is black, so that the sum of the picture is that of the ball wherever it is. While the
// shutter is open, the ball moves by a known number of pixels.
TEST_F(Frames, AreBlurredWhileTheShutterIsOpen) {
    write("ball.toml", R"([space]
hamiltonian = "flat"
[camera]
type = "orthographic"
height = 8
position = [0, -10, 0]
look_at = [0, 0, 0]
up = [0, 0, 1]
[film]
size = [160, 80]
spp = 64
[[object]]
name = "ball"
shape = "sphere"
center = [0, 0, 0]
radius = 0.5
color = [1, 1, 1]
[animation]
frames = 10
[animation.set]
"object.ball.center" = ["frame - 4", "0", "0"]
)");
    const auto columns_of = [&](const std::string& options) {
        EXPECT_EQ(run("render ball.toml --quiet --frames 3:4 -o a-%d.pfm " + options).status, 0);
        const std::string pfm = read("a-3.pfm");
        std::vector<double> columns(160);
        const char* floats = pfm.data() + pfm.size() - std::size_t{160} * 80 * 3 * sizeof(float);
        for (std::size_t i = 0; i < std::size_t{160} * 80; ++i) {
            float red = 0;
            std::memcpy(&red, floats + 3 * i * sizeof(float), sizeof red);
            columns[i % 160] += double(red);
        }
        return columns;
    };
    const auto sum_of = [](const std::vector<double>& columns) {
        double sum = 0;
        for (const double column : columns) sum += column;
        return sum;
    };
    const auto mean_of = [&](const std::vector<double>& columns) {
        double sum = 0;
        for (std::size_t x = 0; x < columns.size(); ++x) sum += columns[x] * (double(x) + 0.5);
        return sum / sum_of(columns);
    };
    const std::vector<double> sharp = columns_of(""), blurred = columns_of("-D camera.shutter=0.5");
    const double area = 3.14159265 * 5 * 5;  // of the ball, 10 pixels per unit of length
    EXPECT_NEAR(sum_of(sharp), area, 0.02 * area);
    EXPECT_NEAR(sum_of(blurred), area, 0.02 * area);
    EXPECT_NEAR(mean_of(sharp), 70, 0.1);      // x = -1
    EXPECT_NEAR(mean_of(blurred), 72.5, 0.1);  // the middle of the way from x = -1 to x = -0.5
    const auto width_of = [](const std::vector<double>& columns) {
        return std::count_if(columns.begin(), columns.end(), [](double column) { return column > 0.01; });
    };
    EXPECT_NEAR(double(width_of(sharp)), 10, 1);
    EXPECT_NEAR(double(width_of(blurred)), 15, 1);
    ASSERT_EQ(run("render ball.toml --quiet -D camera.shutter=0.5 --frames 0:1 -o a-%d.exr --threads 1").status, 0);
    ASSERT_EQ(run("render ball.toml --quiet -D camera.shutter=0.5 -o a.exr --threads 2").status, 0);
    EXPECT_TRUE(read("a.exr") == read("a-0.exr"));
    EXPECT_NE(run("render ball.toml -D camera.shutter=0.5 --part 1/2 -o a.part").err.find("cannot be combined with"),
              std::string::npos);
}

}  // namespace
}  // namespace kagero::test
