// Tests of malformed scenes: the program must end with status 2, print the position and the reason, and write no file.
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

/// A change of the scene `room`, and parts of the expected message.
struct MalformedScene {
    const char* name;
    const char* replaced;  ///< Text that is replaced; "" if `replacement` is appended to the scene.
    const char* replacement;
    std::vector<const char*> messages;
};

void PrintTo(const MalformedScene& scene, std::ostream* out) {
    *out << scene.name;
}

class MalformedScenes : public ProgramTest, public testing::WithParamInterface<MalformedScene> {};

TEST_P(MalformedScenes, EndWithStatus2AndLeaveNoFile) {
    const MalformedScene& malformed = GetParam();
    std::string text = room;
    const std::string replaced = malformed.replaced;
    text.replace(replaced.empty() ? text.size() : text.find(replaced), replaced.size(), malformed.replacement);
    write("scene.toml", text);
    write("model.obj", "v 0 0 0\nv 0.1 0 0\nv 0 nan 0.1\nf 1 2 3\n");
    write("picture.png", "not a picture");
    const auto before = files();
    const Outcome outcome = run("render scene.toml -o out.exr --json out.json --threads 1");
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(files(), before);
    for (const char* part : malformed.messages)
        EXPECT_NE(outcome.err.find(part), std::string::npos) << part << "\n" << outcome.err;
}

INSTANTIATE_TEST_SUITE_P(
    Text, MalformedScenes,
    testing::Values(
        MalformedScene{"Syntax", "fov = 90", "fov = = 90", {"scene.toml:10:"}},
        MalformedScene{"UnknownKey", "escape_radius", "escape_radios", {"scene.toml:5:1", "\"escape_radius\"?"}},
        MalformedScene{"WrongType", "fov = 90", "fov = \"wide\"", {"scene.toml:10:7", "camera.fov", "wide", "number"}},
        MalformedScene{"OutOfRange", "fov = 90", "fov = 180", {"scene.toml:10:7", "180", "0 < value < 180"}},
        MalformedScene{"NotFinite", "rg = 0.08", "rg = nan", {"scene.toml:3:6", "nan", "finite"}},
        MalformedScene{"Negative", "rg = 0.08", "rg = -1", {"scene.toml:3:6", "-1", "0 <= value"}},
        MalformedScene{"FilmOfNoPixels", "size = [8, 8]", "size = [8, 0]", {"scene.toml:12:", "film.size", "65536"}}),
    [](const auto& instance) { return instance.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Data, MalformedScenes,
    testing::Values(
        MalformedScene{"NaNInMesh", "", model, {"scene.toml:21:8", "vertex 2", "finite"}},
        MalformedScene{"MissingMesh",
                       "",
                       "[[object]]\nname = \"m\"\nshape = \"mesh\"\nfile = \"none.obj\"\n",
                       {"scene.toml:21:8", "none.obj"}},
        MalformedScene{"BrokenTexture", "", "texture = \"picture.png\"\n", {"scene.toml:18:", "picture.png"}},
        MalformedScene{"MissingTexture", "", "texture = \"none.png\"\n", {"scene.toml:18:", "none.png"}}),
    [](const auto& instance) { return instance.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Cameras, MalformedScenes,
    testing::Values(
        MalformedScene{"AtTheCentre",
                       "position = [0.2, -0.9, 0.1]\nlook_at = [0, 0, 0]",
                       "position = [0, 0, 0]\nlook_at = [1, 0, 0]",
                       {"scene.toml:7:", "camera.position"}},
        MalformedScene{"InsideTheHorizon", "[0.2, -0.9, 0.1]", "[0.0, -0.05, 0]", {"scene.toml:7:", "camera.position"}},
        MalformedScene{"OnTheHorizon", "[0.2, -0.9, 0.1]", "[0.0, -0.08, 0]", {"scene.toml:7:", "camera.position"}},
        MalformedScene{
            "InAWall", "[0.2, -0.9, 0.1]", "[0.2, -1, 0.1]", {"scene.toml:7:", "[0.2, -1, 0.1]", "surface"}}),
    [](const auto& instance) { return instance.param.name; });

class OutputFiles : public ProgramTest {
protected:
    void SetUp() override {
        ProgramTest::SetUp();
        write("scene.toml", room);
    }
};

TEST_F(OutputFiles, AreRefusedInAReadOnlyFolder) {
    const auto read_only = directory_ / "read-only";
    std::filesystem::create_directory(read_only);
    std::filesystem::permissions(read_only, std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
    if (access(read_only.c_str(), W_OK) == 0) GTEST_SKIP() << "this user can write in every folder";
    const Outcome outcome = run("render scene.toml -o read-only/a.exr");
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_NE(outcome.err.find("permission"), std::string::npos) << outcome.err;
}

TEST_F(OutputFiles, AreNotReplacedByAFailedRun) {
    write("a.exr", "the old picture");
    const auto before = files();
    EXPECT_EQ(run("render scene.toml -o a.exr -D camera.position=[0,0,0.01]").status, 2);
    EXPECT_EQ(run("render scene.toml -o a.exr --json none/a.json").status, 2);
    EXPECT_EQ(read("a.exr"), "the old picture");
    EXPECT_EQ(files(), before);
}

}  // namespace
}  // namespace kagero::test
