// Scenes that are wrong end with status 2, say where and what is legal, and leave nothing behind.
#include "tests/support/program.h"

namespace kagero::test {
namespace {

constexpr const char* room = R"([space]
hamiltonian = "schwarzschild"
rg = 0.08
[integrator]
escape_radius = 4
[camera]
position = [0.2, -0.9, 0.1]
look_at = [0, 0, 0]
up = [0, 0, 1]
fov = 90
[film]
size = [8, 8]
[[object]]
name = "room"
shape = "room"
min = [-1, -1, -1]
max = [1, 1, 1]
)";

constexpr const char* model = R"([[object]]
name = "model"
shape = "mesh"
file = "model.obj"
)";

/// One line of the room written otherwise, or lines put behind it, and what the message must then contain.
struct RoughScene {
    const char* name;
    const char* line;  ///< what is replaced; "" appends
    const char* instead;
    std::vector<const char*> says;
};

void PrintTo(const RoughScene& scene, std::ostream* out) {
    *out << scene.name;
}

class RoughScenes : public ProgramTest, public testing::WithParamInterface<RoughScene> {};

TEST_P(RoughScenes, EndWithStatus2AndLeaveNoFile) {
    const RoughScene& rough = GetParam();
    std::string text = room;
    const std::string line = rough.line;
    text.replace(line.empty() ? text.size() : text.find(line), line.size(), rough.instead);
    write("scene.toml", text);
    write("model.obj", "v 0 0 0\nv 0.1 0 0\nv 0 nan 0.1\nf 1 2 3\n");
    write("picture.png", "not a picture");
    const auto before = files();
    const Outcome outcome = run("render scene.toml -o out.exr --json out.json --threads 1");
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(files(), before);
    for (const char* part : rough.says)
        EXPECT_NE(outcome.err.find(part), std::string::npos) << part << "\n" << outcome.err;
}

INSTANTIATE_TEST_SUITE_P(
    Text, RoughScenes,
    testing::Values(
        RoughScene{"Syntax", "fov = 90", "fov = = 90", {"scene.toml:10:"}},
        RoughScene{"UnknownKey", "escape_radius", "escape_radios", {"scene.toml:5:1", "\"escape_radius\"?"}},
        RoughScene{"WrongType", "fov = 90", "fov = \"wide\"", {"scene.toml:10:7", "camera.fov", "wide", "number"}},
        RoughScene{"OutOfRange", "fov = 90", "fov = 180", {"scene.toml:10:7", "180", "0 < value < 180"}},
        RoughScene{"NotFinite", "rg = 0.08", "rg = nan", {"scene.toml:3:6", "nan", "finite"}},
        RoughScene{"Negative", "rg = 0.08", "rg = -1", {"scene.toml:3:6", "-1", "0 <= value"}},
        RoughScene{"FilmOfNoPixels", "size = [8, 8]", "size = [8, 0]", {"scene.toml:12:", "film.size", "65536"}}),
    [](const auto& chosen) { return chosen.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Data, RoughScenes,
    testing::Values(RoughScene{"NaNInMesh", "", model, {"scene.toml:21:8", "vertex 2", "finite"}},
                    RoughScene{"MissingMesh",
                               "",
                               "[[object]]\nname = \"m\"\nshape = \"mesh\"\nfile = \"none.obj\"\n",
                               {"scene.toml:21:8", "none.obj"}},
                    RoughScene{"BrokenTexture", "", "texture = \"picture.png\"\n", {"scene.toml:18:", "picture.png"}},
                    RoughScene{"MissingTexture", "", "texture = \"none.png\"\n", {"scene.toml:18:", "none.png"}}),
    [](const auto& chosen) { return chosen.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Cameras, RoughScenes,
    testing::Values(
        RoughScene{"AtTheCentre",
                   "position = [0.2, -0.9, 0.1]\nlook_at = [0, 0, 0]",
                   "position = [0, 0, 0]\nlook_at = [1, 0, 0]",
                   {"scene.toml:7:", "camera.position"}},
        RoughScene{"InsideTheHorizon", "[0.2, -0.9, 0.1]", "[0.0, -0.05, 0]", {"scene.toml:7:", "camera.position"}},
        RoughScene{"OnTheHorizon", "[0.2, -0.9, 0.1]", "[0.0, -0.08, 0]", {"scene.toml:7:", "camera.position"}},
        RoughScene{"InAWall", "[0.2, -0.9, 0.1]", "[0.2, -1, 0.1]", {"scene.toml:7:", "[0.2, -1, 0.1]", "surface"}}),
    [](const auto& chosen) { return chosen.param.name; });

class RoughOutputs : public ProgramTest {
protected:
    void SetUp() override {
        ProgramTest::SetUp();
        write("scene.toml", room);
    }
};

TEST_F(RoughOutputs, AClosedDirectoryIsFoundBeforeRendering) {
    const auto closed = directory_ / "closed";
    std::filesystem::create_directory(closed);
    std::filesystem::permissions(closed, std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
    if (access(closed.c_str(), W_OK) == 0) GTEST_SKIP() << "no directory is closed to this user";
    const Outcome outcome = run("render scene.toml -o closed/a.exr");
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_NE(outcome.err.find("permission"), std::string::npos) << outcome.err;
}

// What was there before stays whole until the new picture is complete.
TEST_F(RoughOutputs, AFailedRunKeepsTheOldPicture) {
    write("a.exr", "the old picture");
    const auto before = files();
    EXPECT_EQ(run("render scene.toml -o a.exr -D camera.position=[0,0,0.01]").status, 2);
    EXPECT_EQ(run("render scene.toml -o a.exr --json none/a.json").status, 2);
    EXPECT_EQ(read("a.exr"), "the old picture");
    EXPECT_EQ(files(), before);
}

}  // namespace
}  // namespace kagero::test
