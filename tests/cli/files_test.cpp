// Tests of output files: they must differ from the input files, and a failed or interrupted run must leave no
// incomplete file. Also tests options and messages of whole runs.
#include "tests/support/hole_scene.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <map>

namespace kagero::test {
namespace {

using nlohmann::json;

class Files : public HoleTest {
protected:
    void SetUp() override {
        HoleTest::SetUp();
        write("rays.csv", "x,y,z,dx,dy,dz\n3,0,0,-1,0.3,0\n");
        ASSERT_EQ(run("render hole.toml --quiet -o sky.png").status, 0);
        write("sky.toml", std::string(hole).substr(0, std::string(hole).rfind("checker")) + "texture = \"sky.png\"\n");
    }
};

TEST_F(Files, AreRefusedAsOutputIfTheyAreInput) {
    std::filesystem::create_hard_link(directory_ / "hole.toml", directory_ / "linked");
    for (const char* arguments :
         {"render hole.toml -o a.exr --json hole.toml", "render hole.toml -o a.exr --json ./linked",
          "trace hole.toml --rays rays.csv -o hole.toml", "trace hole.toml --rays rays.csv --json rays.csv",
          "explain hole.toml --json hole.toml", "compare hole.toml --json hole.toml", "render sky.toml -o sky.png",
          "print sky.toml -o sky.png", "error hole.toml -o . --json hole.toml", "profile sky.toml --json sky.png",
          "render hole.toml --layers color,steps --maps -o a.exr --json a-steps.png"}) {
        const auto before = files();
        const std::string scene = read("hole.toml"), rays = read("rays.csv"), sky = read("sky.png");
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.status, 2) << arguments;
        EXPECT_NE(outcome.err.find("are the same file"), std::string::npos) << arguments << '\n' << outcome.err;
        EXPECT_EQ(read("hole.toml"), scene) << arguments;
        EXPECT_EQ(read("rays.csv"), rays) << arguments;
        EXPECT_EQ(read("sky.png"), sky) << arguments;
    }
}

// A limit on the size of files and the device /dev/full stand for a full disk. In every picture format, the program
// must keep the previous file and print an error.
TEST_F(Files, KeepThePreviousPictureIfTheDiskIsFull) {
    for (const char* extension : {"exr", "png", "jpg", "tif", "bmp", "tga", "ppm", "webp", "hdr", "pfm"}) {
        const std::string name = std::string("picture.") + extension;
        write(name, "previous file");
        const auto before = files();
        const Outcome outcome = run("render hole.toml --size 256x256 --quiet -o " + name, "trap '' XFSZ; ulimit -f 2;");
        EXPECT_EQ(outcome.status, 1) << name;
        EXPECT_NE(outcome.err.find("kagero: error: "), std::string::npos) << name << '\n' << outcome.err;
        EXPECT_EQ(read(name), "previous file") << name;
        EXPECT_EQ(files(), before) << name;
        EXPECT_EQ(run("render hole.toml --quiet -o /dev/full", "ln -sf /dev/full full." + std::string(extension) + ";")
                      .status,
                  2);
        EXPECT_EQ(run("render hole.toml --quiet -o full." + std::string(extension)).status, 1) << name;
        std::filesystem::remove(directory_ / ("full." + std::string(extension)));
    }
}

// A file name has at most 255 bytes.
TEST_F(Files, CanHaveTheLongestNameOfTheFileSystem) {
    const std::string longest(251, 'a');
    EXPECT_EQ(run("render hole.toml --quiet -o " + longest + ".exr").status, 0);
    EXPECT_TRUE(exists(longest + ".exr"));
    const Outcome longer = run("render hole.toml --quiet -o a" + longest + ".exr");
    EXPECT_EQ(longer.status, 2) << longer.err;
    std::filesystem::create_symlink("loop.exr", directory_ / "loop.exr");
    EXPECT_EQ(run("render hole.toml --quiet -o loop.exr").status, 2);
}

// The first run creates the target of the link, and the second run replaces it.
TEST_F(Files, AreWrittenToTheTargetOfALink) {
    std::filesystem::create_directory(directory_ / "target");
    std::filesystem::create_symlink("target/picture.exr", directory_ / "link.exr");
    for (int i = 0; i < 2; ++i) {
        EXPECT_EQ(run("render hole.toml --quiet -o link.exr").status, 0);
        EXPECT_TRUE(std::filesystem::is_symlink(directory_ / "link.exr"));
        EXPECT_TRUE(std::filesystem::is_regular_file(directory_ / "target" / "picture.exr"));
    }
    std::filesystem::create_symlink("missing/picture.exr", directory_ / "broken.exr");
    EXPECT_EQ(run("render hole.toml --quiet -o broken.exr").status, 2);
}

TEST_F(Files, AreTheSamePictureWithAndWithoutAReport) {
    const std::string render = "render hole.toml --quiet --layers color,energy_error ";
    ASSERT_EQ(run(render + "-o a.exr").status, 0);
    ASSERT_EQ(run(render + "-o b.exr --json b.json").status, 0);
    EXPECT_EQ(read("a.exr"), read("b.exr"));
    EXPECT_NE(read("a.exr").find("kagero/energy_error"), std::string::npos);
}

/// Shell script that runs a program and interrupts it. The signal is sent after the program has installed its signal
/// handler and has used 30 ticks (0.3 s) of processor time.
constexpr const char* interrupt_script =
    "\"$@\" 2>log & until grep -q '^SigCgt:.*[2367abef]$' /proc/$!/status; do kill -0 $! || break; sleep 0.02; done\n"
    "until test \"$(cut -d ' ' -f 14 /proc/$!/stat)\" -ge 30; do kill -0 $! || break; sleep 0.02; done; kill -INT $!; "
    "wait $!\n";

TEST_F(Files, ContainTheTracedRaysOfAnInterruptedRun) {
    std::string rays = "x,y,z,dx,dy,dz\n";
    for (int i = 0; i < 20000; ++i) rays += "-20," + std::to_string(0.3 + 1e-6 * i) + ",0,1,0,0\n";
    write("many.csv", rays);
    write("interrupt.sh", interrupt_script);
    const Outcome outcome =
        run("trace hole.toml --rays many.csv --integrator gauss8 --step 0.0002 --threads 1 -o ends.csv",
            "sh interrupt.sh");
    EXPECT_EQ(outcome.status, 130) << read("log");
    const auto rows = lines_of(read("ends.csv"));
    ASSERT_EQ(rows.size(), 20001u);
    const auto untraced = std::count_if(rows.begin(), rows.end(), [](const std::string& row) {
        return row.ends_with("interrupted before this ray was traced");
    });
    EXPECT_GT(untraced, 0);
}

// A single tile of this picture takes minutes. The program must end before the tile is finished, and write the
// picture.
TEST_F(Files, AreWrittenWithoutFinishingATile) {
    write("interrupt.sh", interrupt_script);
    const std::string endless =
        "render hole.toml --size 4x4 --spp 4096 --quiet --precision double --integrator gauss16 --step 1e-6 -D "
        "integrator.max_steps=4000000000 --threads 1 ";
    EXPECT_EQ(run(endless + "-o a.exr", "timeout 300 sh interrupt.sh").status, 130);
    EXPECT_TRUE(exists("a.exr"));
    EXPECT_EQ(run(endless + "-o b.exr --time-limit 0.5", "timeout 300").status, 0);
    EXPECT_TRUE(exists("b.exr"));
}

TEST_F(Files, AreNotWrittenByAnErrorStudyWithoutReference) {
    write("interrupt.sh", interrupt_script);
    const std::string long_study =
        "error hole.toml --sample 512x512 -D integrator.escape_radius=1e5 -D integrator.symmetry=none -D "
        "integrator.step=1e-4 -D integrator.max_steps=4000000000 -o new/report";
    EXPECT_EQ(run(long_study, "timeout 300 sh interrupt.sh").status, 130) << read("log");
    EXPECT_FALSE(exists("new"));
    EXPECT_EQ(run("error hole.toml --quick -D integrator.max_steps=1 -o new").status, 1);
    EXPECT_FALSE(exists("new"));
}

// If the profile is interrupted in its first round, it must create no folder and keep an existing report.
TEST_F(Files, AreNotWrittenByAProfileWithoutACompleteRound) {
    write("interrupt.sh", interrupt_script);
    const std::string endless =
        "profile hole.toml --size 4x4 --spp 4096 --precision double --integrator gauss16 --step 1e-6 -D "
        "integrator.max_steps=4000000000 --threads 1 ";
    EXPECT_EQ(run(endless + "-o new", "timeout 300 sh interrupt.sh").status, 130);
    EXPECT_FALSE(exists("new"));
    EXPECT_EQ(run("profile hole.toml --size 8x8 --repeat 1 -o old").status, 0);
    EXPECT_EQ(run(endless + "-o old", "timeout 300 sh interrupt.sh").status, 130);
    EXPECT_TRUE(exists("old/report.html"));
}

TEST_F(Files, ContainNoPathOfARayThatCannotStart) {
    write("rays.csv", "x,y,z,dx,dy,dz\n0,-2,0,1,0,0\n0,-2,0,0,0,0\n");
    const Outcome outcome = run("trace hole.toml --rays rays.csv --path");
    ASSERT_EQ(outcome.status, 0);
    EXPECT_EQ(outcome.out.find("\n1,"), std::string::npos);
    EXPECT_NE(outcome.err.find("1 ray has no path: ray 1 failed at its start: the direction has length zero"),
              std::string::npos)
        << outcome.err;
    // Within the ergosphere light can have negative energy. Such a ray, traced backward, is captured at its start.
    write("kerr.toml",
          "space = { hamiltonian = \"kerr\", spin = 0.9 }\ncamera = { position = [1.8358, 0, 0], look_at = [1.8358, 1, "
          "0], up = [0, 0, 1], observer = \"zamo\" }\n"
          "film.size = [9, 9]\n");
    write("rays.csv", "x,y,z,dx,dy,dz\n1.8358,0,0,0,1,0\n1.8358,0,0,0,-1,0\n");
    EXPECT_NE(run("trace kerr.toml --observer zamo --rays rays.csv --path")
                  .err.find("1 ray has no path: ray 0 is captured at its start"),
              std::string::npos);
    write("inside.toml",
          "space.hamiltonian = \"schwarzschild\"\ncamera = { type = \"orthographic\", position = [3, 0, 0], look_at = "
          "[3, 1, 0], up = [0, 0, 1], height = 8 }\n"
          "film.size = [64, 64]\n");
    EXPECT_NE(run("render inside.toml --pixel 8,32").err.find("1 ray has no path: ray 0 failed at its start: "),
              std::string::npos);
}

// The path of the last of 5000 rays is compared with its path as the only ray.
TEST_F(Files, ContainTheSamePathForOneRayAndForManyRays) {
    std::string rays = "x,y,z,dx,dy,dz\n";
    for (int i = 0; i < 5000; ++i) rays += "0,-2," + std::to_string(1e-4 * i) + ",0,1,0\n";
    write("many.csv", rays);
    write("last.csv", "x,y,z,dx,dy,dz\n0,-2," + std::to_string(1e-4 * 4999) + ",0,1,0\n");
    const auto path_of = [&](const char* file, const std::string& number) {
        std::string path;
        for (const std::string& row : lines_of(run(std::string("trace hole.toml --path --rays ") + file).out))
            if (row.starts_with(number + ",")) path += row.substr(number.size()) + "\n";
        return path;
    };
    const std::string alone = path_of("last.csv", "0");
    EXPECT_GT(lines_of(alone).size(), 2u);
    EXPECT_EQ(path_of("many.csv", "4999"), alone);
}

class Runs : public HoleTest {};

TEST_F(Runs, UseOptionsInsteadOfEnvironmentVariables) {
    const std::string render = "render hole.toml --quiet --json -o a.exr ";
    EXPECT_EQ(json::parse(run(render + "--threads 3", "KAGERO_THREADS=2").out)["threads"], 3);
    EXPECT_EQ(json::parse(run(render, "KAGERO_THREADS=2").out)["threads"], 2);
    EXPECT_EQ(run(render + "--threads 0", "KAGERO_THREADS=2").status, 2);
    const std::string isas = KAGERO_BUILT_ISAS;
    const std::string first_isa = isas.substr(0, isas.find(','));
    EXPECT_EQ(json::parse(run(render + "--isa " + first_isa, "KAGERO_ISA=auto").out)["isa"], first_isa);
    EXPECT_EQ(json::parse(run(render, "KAGERO_ISA=" + first_isa).out)["isa"], first_isa);
    EXPECT_EQ(run(render + "--isa nope", "KAGERO_ISA=" + first_isa).status, 2);
}

// Only adaptive methods use a tolerance. If a scene states a tolerance without a method, an adaptive method is chosen.
// With another method, the program must print that the tolerance has no effect.
TEST_F(Runs, UseTheStatedToleranceIfTheMethodIsAdaptive) {
    const json coarse = json::parse(run("render hole.toml --quiet --json -o a.exr -D integrator.tolerance=1e-3").out);
    const json fine = json::parse(run("render hole.toml --quiet --json -o a.exr -D integrator.tolerance=1e-11").out);
    EXPECT_EQ(coarse["integrator"], "dp85");
    EXPECT_LT(coarse["gradients"], fine["gradients"]);
    const Outcome ignored = run("render hole.toml -o a.exr -D integrator.tolerance=1e-3 --integrator gauss8");
    EXPECT_EQ(ignored.status, 0);
    EXPECT_NE(ignored.err.find("integrator.tolerance has no effect"), std::string::npos) << ignored.err;
    const Outcome too_fine = run("render hole.toml -o a.exr -D integrator.tolerance=1e-300");
    EXPECT_NE(too_fine.err.find("rays failed"), std::string::npos) << too_fine.err;
    EXPECT_NE(too_fine.err.find("try another integrator.tolerance"), std::string::npos) << too_fine.err;
    EXPECT_EQ(too_fine.err.find("integrator.step"), std::string::npos) << too_fine.err;
}

// No message is printed if nearly all rays end within the step limit.
TEST_F(Runs, PrintAMessageIfManyRaysReachTheStepLimit) {
    const auto messages_with = [&](const char* max_steps) {
        return run(std::string(
                       "render hole.toml --size 16x16 -o a.exr --integrator dp5 --step 0.25 -D integrator.max_steps=") +
                   max_steps)
            .err;
    };
    EXPECT_NE(messages_with("3").find("all 256 rays did not end within integrator.max_steps = 3"), std::string::npos);
    const json report = json::parse(run("render hole.toml --size 16x16 -o a.exr --integrator dp5 --step 0.25 --quiet "
                                        "--json -D integrator.max_steps=20")
                                        .out);
    const int unfinished = report["status"]["step_limit"];
    ASSERT_GT(unfinished, 2);
    ASSERT_LT(unfinished, 256);
    EXPECT_NE(messages_with("20").find(std::to_string(unfinished) + " of 256 rays did not end"), std::string::npos)
        << messages_with("20");
    EXPECT_EQ(messages_with("10000").find("max_steps"), std::string::npos);
}

// The squares of the longest direction overflow, and those of the shortest underflow.
TEST_F(Runs, DoNotDependOnTheLengthOfADirection) {
    std::map<std::string, std::string> outputs;  // output of each observer for length 1
    for (const char* length : {"1", "1e150", "1e300", "1e-150", "1e-300", "4e-320"}) {
        write("ray.csv", std::string("x,y,z,dx,dy,dz\n-20,3,0,") + length + ",0,0\n");
        for (const char* observer : {"static", "falling", "coordinate"}) {
            const Outcome outcome = run(std::string("trace hole.toml --rays ray.csv --observer ") + observer);
            ASSERT_EQ(outcome.status, 0) << outcome.err;
            const auto& expected = outputs.emplace(observer, outcome.out).first->second;
            EXPECT_EQ(outcome.out, expected) << observer << ' ' << length;
        }
    }
}

}  // namespace
}  // namespace kagero::test
