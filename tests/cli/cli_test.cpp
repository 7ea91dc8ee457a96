// Tests of the command line: output, files and exit status.
#include "tests/support/hole_scene.h"

#include <OpenImageIO/imageio.h>
#include <nlohmann/json.hpp>

namespace kagero::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class Cli : public HoleTest {};

TEST_F(Cli, PrintsHelpAndVersionOnStdout) {
    for (const char* arguments :
         {"--help", "render --help", "trace --help", "explain --help", "check --help", "print --help", "compare --help",
          "error --help", "stability --help", "profile --help", "list --help"}) {
        const Outcome help = run(arguments);
        EXPECT_EQ(help.status, 0) << arguments;
        EXPECT_NE(help.out.find("Usage: kagero"), std::string::npos) << arguments;
        EXPECT_EQ(help.err, "") << arguments;
    }
    const Outcome version = run("--version");
    EXPECT_EQ(version.status, 0);
    EXPECT_EQ(version.out.rfind("kagero ", 0), 0u) << version.out;
}

TEST_F(Cli, ChecksEnvironmentVariablesLikeOptions) {
    EXPECT_EQ(run("check hole.toml", "KAGERO_THREADS=many").status, 2);
    EXPECT_EQ(run("check hole.toml", "KAGERO_ISA=sse9").status, 2);
    EXPECT_EQ(run("check hole.toml", "KAGERO_FORMULA=never").status, 2);
    EXPECT_NE(run("check hole.toml", "KAGERO_ISA=all").err.find("KAGERO_ISA all: not one of"), std::string::npos);
    EXPECT_EQ(run("check hole.toml", "KAGERO_THREADS=1").status, 0);
}

TEST_F(Cli, UsesColoursOnlyInTerminalsOrOnRequest) {
    EXPECT_EQ(run("rendr").err.find('\033'), std::string::npos);
    EXPECT_NE(run("render missing.toml --color always").err.find('\033'), std::string::npos);
    EXPECT_EQ(run("render missing.toml --color never").err.find('\033'), std::string::npos);
}

TEST_F(Cli, ListsEveryTopic) {
    const Outcome all = run("list --json");
    ASSERT_EQ(all.status, 0) << all.err;
    const json topics = json::parse(all.out);
    // A program in build/PRESET/bin finds the scenes of the source tree. A build elsewhere has no scenes until it is
    // installed.
    const bool has_scenes = fs::is_directory(fs::path(KAGERO_BINARY).parent_path() / "../../../scenes");
    for (const char* topic : {"hamiltonians", "integrators", "strategies", "isas", "scenes", "layers"}) {
        ASSERT_TRUE(topics.contains(topic)) << topic;
        EXPECT_EQ(topics[topic].empty(), topic == std::string("scenes") && !has_scenes) << topic;
        const Outcome text = run(std::string("list ") + topic);
        EXPECT_EQ(text.status, 0);
        for (const json& item : topics[topic])
            EXPECT_NE(text.out.find(item["name"].get<std::string>()), std::string::npos) << item;
    }
    EXPECT_EQ(json::parse(run("list --json layers").out).size(), 1u);
}

TEST_F(Cli, AcceptsThePrintedScene) {
    const Outcome check = run("check hole.toml");
    EXPECT_EQ(check.status, 0) << check.err;
    const Outcome once = run("print hole.toml -D space.rg=0.25 --size 7x9");
    ASSERT_EQ(once.status, 0) << once.err;
    EXPECT_NE(once.out.find("0.25"), std::string::npos);
    write("again.toml", once.out);
    EXPECT_EQ(run("print again.toml").out, once.out);
    // The default method of the fisheye may not support an H that an expression rescales.
    write("fisheye.toml",
          "[space]\nhamiltonian = \"fisheye\"\n[integrator]\nrescale = \"1 + r^2\"\n[camera]\nposition = [-2, 0, "
          "0]\nlook_at = [0, 0, 0]\n"
          "[film]\nsize = [4, 4]\n");
    const Outcome rescaled = run("print fisheye.toml -o printed.toml");
    ASSERT_EQ(rescaled.status, 0) << rescaled.err;
    const Outcome loaded = run("check printed.toml");
    EXPECT_EQ(loaded.status, 0) << loaded.err;
}

TEST_F(Cli, RendersIntoTheWorkingDirectoryAndReports) {
    const Outcome outcome = run("render hole.toml --json --quiet");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    EXPECT_TRUE(exists("hole.exr"));
    const json report = json::parse(outcome.out);
    for (const char* key : {"scene",       "isa",          "strategy",  "precision", "lanes",
                            "threads",     "width",        "height",    "rays",      "seconds",
                            "mrays_per_s", "steps",        "gradients", "queries",   "lane_occupancy",
                            "status",      "energy_error", "load_s",    "write_s",   "iteration_occupancy"})
        EXPECT_TRUE(report.contains(key)) << key;
    EXPECT_EQ(report["rays"], 16 * 8);
    std::uint64_t ends = 0;
    for (const char* status : {"hit", "escaped", "captured", "step_limit", "failed"})
        ends += report["status"][status].get<std::uint64_t>();
    EXPECT_EQ(ends, 16u * 8u);
    EXPECT_TRUE(report["energy_error"]["max"].is_number());
    EXPECT_EQ(report["vectorization_ratio"], 1);  // the kernel generates the rays in packets; there are no surfaces
    // With two rays per pixel, the program generates the ray starts one at a time.
    const double ratio_with_two_rays =
        json::parse(run("render hole.toml --json --quiet --size 16x8 -D film.spp=2").out)["vectorization_ratio"];
    EXPECT_GT(ratio_with_two_rays, 0.9);
    EXPECT_LT(ratio_with_two_rays, 1);
    EXPECT_EQ(json::parse(run("render hole.toml --json --quiet --strategy scalar").out)["vectorization_ratio"], 0);
    EXPECT_TRUE(json::parse(run("render hole.toml --json --quiet -D space.rg=0").out)["vectorization_ratio"].is_null());
}

TEST_F(Cli, WritesTheSamePictureWithMoreThreadsAndAReport) {
    ASSERT_EQ(run("render hole.toml --layers color,steps,status -o one.exr --threads 1").status, 0);
    ASSERT_EQ(run("render hole.toml --layers color,steps,status -o two.exr --threads 3 --json report.json").status, 0);
    EXPECT_EQ(read("one.exr"), read("two.exr"));
    EXPECT_TRUE(json::accept(read("report.json")));
    EXPECT_EQ(files().size(), 4u);
}

// The value of --json is optional. A word that follows must be read as the scene, not as the value.
TEST_F(Cli, ReadsTheSceneAfterJsonWithoutValue) {
    const Outcome outcome = run("render --json hole.toml -o a.png --quiet");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_TRUE(json::accept(outcome.out));
    EXPECT_NE(read("hole.toml").find("[space]"), std::string::npos);
}

TEST_F(Cli, ReadsWordsAfterTwoDashesAsFiles) {
    write("-dash.toml", read("hole.toml"));
    EXPECT_EQ(run("check --quiet -- -dash.toml").status, 0);
    EXPECT_EQ(run("check -dash.toml").status, 2);
    EXPECT_EQ(run("check hole.toml -- --quiet").status, 2);
}

TEST_F(Cli, WritesThePathOfAPixel) {
    const Outcome outcome = run("render hole.toml --pixel 3,2");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto lines = lines_of(outcome.out);
    ASSERT_GE(lines.size(), 2u);
    EXPECT_EQ(lines[0], "ray,step,parameter,x,y,z,dx,dy,dz,px,py,pz,pt,energy");
    EXPECT_EQ(lines[1].rfind("0,0,0,0,-2,0,", 0), 0u) << lines[1];
    EXPECT_FALSE(exists("hole.exr"));
}

TEST_F(Cli, TracesListedRaysInOrder) {
    // The columns are in a different order, and lines end with CR LF. One ray escapes, one is captured, and two are
    // invalid.
    write("rays.csv", "dx,dy,dz,x,y,z\r\n0,-1,0,0,-2,0\r\n\r\n0,+1,0,0,-2,0\r\n 0, 0, 0,0,-2,0\r\nnan,0,0,0,-2,0\r\n");
    const Outcome outcome = run("trace hole.toml", "<rays.csv");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto lines = lines_of(outcome.out);
    ASSERT_EQ(lines.size(), 5u) << outcome.out;
    EXPECT_EQ(lines[0], "ray,status,object,x,y,z,dx,dy,dz,px,py,pz,pt,parameter,steps,gradients,energy_error,reason");
    EXPECT_EQ(lines[1].rfind("0,escaped,,", 0), 0u) << lines[1];
    EXPECT_EQ(lines[2].rfind("1,captured,,", 0), 0u) << lines[2];
    EXPECT_EQ(lines[3].rfind("2,failed,,", 0), 0u) << lines[3];
    EXPECT_EQ(lines[4].rfind("3,failed,,", 0), 0u) << lines[4];
    EXPECT_EQ(lines[1].back(), ',') << "an escaped ray has no reason";
    EXPECT_NE(lines[3].back(), ',') << "a failed ray has a reason";
}

TEST_F(Cli, ReportsOnTracedRays) {
    write("rays.csv", "x,y,z,dx,dy,dz\n0,-2,0,1,0,0\n0,-2,0,0,-1,0\n");
    const Outcome alone = run("trace hole.toml --rays rays.csv --json --repeat 3");
    ASSERT_EQ(alone.status, 0) << alone.err;
    const json report = json::parse(alone.out);
    for (const char* key : {"rays", "threads", "strategy", "precision", "isa", "ns_per_ray", "steps_per_ray",
                            "gradients_per_ray", "lane_occupancy", "status"})
        EXPECT_TRUE(report.contains(key)) << key;
    EXPECT_EQ(report["rays"], 2);
    EXPECT_LE(report["ns_per_ray"]["min"], report["ns_per_ray"]["median"]);
    EXPECT_LE(report["ns_per_ray"]["median"], report["ns_per_ray"]["max"]);

    const Outcome both = run("trace hole.toml --rays rays.csv --json report.json");
    EXPECT_EQ(lines_of(both.out).size(), 3u);
    EXPECT_TRUE(json::accept(read("report.json")));
}

TEST_F(Cli, TracesToAParameter) {
    write("rays.csv", "x,y,z,dx,dy,dz\n0,-2,0,1,0,0\n");
    const Outcome ends = run("trace hole.toml --rays rays.csv --parameter 0.75");
    ASSERT_EQ(ends.status, 0) << ends.err;
    EXPECT_NE(ends.out.find("0,step_limit,,"), std::string::npos) << ends.out;
    EXPECT_NE(ends.out.find(",0.75,"), std::string::npos) << ends.out;
    const Outcome angular = run("trace hole.toml --rays rays.csv --parameter 0.75 --integrator orbit-srkn6");
    EXPECT_EQ(angular.status, 2);
    EXPECT_NE(angular.err.find("steps in an angle"), std::string::npos) << angular.err;
    const Outcome path = run("trace hole.toml --rays rays.csv --parameter 0.75 --path");
    ASSERT_EQ(path.status, 0) << path.err;
    EXPECT_EQ(lines_of(path.out).back().find(",0.75,"), lines_of(path.out).back().find(',', 2)) << path.out;
}

TEST_F(Cli, WritesNoDirectionOfRaysThatCannotStart) {
    write("rays.csv", "x,y,z,dx,dy,dz\n0,-2,0,0,0,0\n0,-2,0,inf,0,0\n0,0,0,1,0,0\n1e200,0,0,-1,0,0\n");
    for (const char* observer : {"", " --observer static"}) {
        const Outcome outcome = run(std::string("trace hole.toml --rays rays.csv") + observer);
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        const auto lines = lines_of(outcome.out);
        ASSERT_EQ(lines.size(), 5u);
        for (std::size_t i = 1; i < lines.size(); ++i)
            // The columns from dx to energy_error.
            EXPECT_NE(lines[i].find(",0,0,0,0,0,0,0,0,0,0,nan,"), std::string::npos) << lines[i];
        EXPECT_NE(lines[4].find("too far from the origin"), std::string::npos) << lines[4];
    }
}

TEST_F(Cli, ReportsOnAValidScene) {
    const Outcome outcome = run("check hole.toml --json");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const json report = json::parse(outcome.out);
    EXPECT_EQ(report["valid"], true);
    EXPECT_EQ(report["hamiltonian"], "schwarzschild");
    EXPECT_TRUE(report["remarks"].empty());
}

TEST_F(Cli, ReportsTheErrorOfAnInvalidScene) {
    for (const std::string wrong : {"film.spp=0", "object=[{name=\"a\",shape=\"mesh\",file=\"none.obj\"}]"}) {
        const Outcome outcome = run("check hole.toml --json -D '" + wrong + "'");
        EXPECT_EQ(outcome.status, 2);
        const json report = json::parse(outcome.out);
        EXPECT_EQ(report["valid"], false);
        EXPECT_NE(outcome.err.find(report["error"].get<std::string>()), std::string::npos) << outcome.err;
    }
    const std::string scene = read("hole.toml");
    EXPECT_EQ(run("check hole.toml --json hole.toml -D film.spp=0").status, 2);
    EXPECT_EQ(read("hole.toml"), scene);
}

// Both rays start outside the escape sphere, whose radius is 50. The first ray misses the sphere. The second ray passes
// through the sphere and must end on it. Both rays must escape.
TEST_F(Cli, EndsRaysFromOutsideTheEscapeSphere) {
    write("rays.csv", "x,y,z,dx,dy,dz\n100,60,0,-1,0,0\n100,30,0,-1,0,0\n");
    for (const char* options : {"-D space.rg=0", "-D space.rg=0 --path", "", "--integrator gauss8 --step 0.2",
                                "--integrator dp5 --step 0.2 --precision float"}) {
        SCOPED_TRACE(options);
        const Outcome outcome = run(std::string("trace hole.toml --rays rays.csv ") + options);
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_EQ(outcome.out.find("failed"), std::string::npos) << outcome.out;
        std::string x, y;
        std::istringstream last(lines_of(outcome.out).back());
        for (int column = 0; column < 5 && std::getline(last, column == 3 ? x : y, ','); ++column) {}
        EXPECT_NEAR(std::hypot(std::stod(x), std::stod(y)), 50, 1e-4);
    }
}

// The derivative of H is infinite at x = 1, where the ray fails. The path must contain each step once, and the ray end.
TEST_F(Cli, WritesThePathOfAFailedRayToItsEnd) {
    write("edge.toml", "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2) - 0.5*sqrt(1 - x)\"\n"
                       "[camera]\nposition = [0, -2, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [8, 8]\n");
    write("rays.csv", "x,y,z,dx,dy,dz\n0,0,0,1,0,0\n");
    const std::string command = "trace edge.toml --rays rays.csv --integrator rk4 --step 0.05";
    const std::string end = lines_of(run(command).out).back();
    ASSERT_EQ(end.rfind("0,failed,,", 0), 0u) << end;
    std::set<std::string> steps;
    const Outcome path = run(command + " --path");
    for (const std::string& line : lines_of(path.out))
        EXPECT_TRUE(steps.insert(line.substr(0, line.find(',', 2))).second) << line;
    EXPECT_NE(path.out.find(end.substr(10, end.find(',', 10) - 10)), std::string::npos) << path.out;
}

// The default method of the mirage supports only the rescaled H, with which a ray cannot end at a given λ. The program
// must choose another method, and refuse the default method if the command states it.
TEST_F(Cli, ChoosesAnotherMethodForAParameter) {
    write("air.toml",
          "[space]\nhamiltonian = \"mirage\"\n[camera]\nposition = [0, -3, 0.2]\nlook_at = [0, 0, 0.2]\nup = [0, 0, "
          "1]\n[film]\nsize = [8, 8]\n");
    write("ray.csv", "x,y,z,dx,dy,dz\n0,0,0,1,0,0\n");
    const Outcome outcome = run("trace air.toml --rays ray.csv --parameter 3");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const std::string end = lines_of(outcome.out)[1];
    EXPECT_TRUE(end.starts_with("0,step_limit,")) << end;
    EXPECT_NE(end.find(",3,"), std::string::npos) << end;
    const Outcome stated = run("trace air.toml --rays ray.csv --parameter 3 --integrator srkn6");
    EXPECT_EQ(stated.status, 2);
    EXPECT_NE(stated.err.find("srkn6"), std::string::npos) << stated.err;
}

TEST_F(Cli, EndsWithStatus1IfTheDiskIsFull) {
    const Outcome outcome = run("print hole.toml -o /dev/full");
    EXPECT_EQ(outcome.status, 1) << outcome.err;
    EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

// Two threads need minutes for this picture. The number of threads is limited, because a large machine could otherwise
// finish the picture before the signal. The shell sends the signal when the scene is loaded.
TEST_F(Cli, WritesThePartOfThePictureThatIsDoneIfInterrupted) {
    write("interrupt.sh",
          "\"$@\" 2>log & until grep -q loaded log; do kill -0 $! || break; sleep 0.05; done; kill -INT $!; wait $!\n");
    const Outcome outcome =
        run("render hole.toml --size 512x512 -D integrator.step=0.0005 --threads 2 -o part.exr --json report.json "
            "--verbose",
            "sh interrupt.sh");
    EXPECT_EQ(outcome.status, 130) << read("log");
    EXPECT_TRUE(json::parse(read("report.json"))["interrupted"].get<bool>());
    EXPECT_EQ(files(), (std::set<std::string>{"hole.toml", "interrupt.sh", "log", "part.exr", "report.json"}));
}

TEST_F(Cli, WritesThePartOfThePictureThatIsDoneAtTheTimeLimit) {
    const Outcome outcome =
        run("render hole.toml --size 512x512 -D integrator.step=0.0005 --threads 2 -o part.exr --time-limit 0.5 --json "
            "report.json");
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("the time limit was reached"), std::string::npos) << outcome.err;
    const json report = json::parse(read("report.json"));
    EXPECT_TRUE(report["out_of_time"].get<bool>());
    EXPECT_LT(report["rays"], 512 * 512);
    // The file has the size of the whole picture.
    const auto part = OIIO::ImageInput::open((directory_ / "part.exr").string());
    ASSERT_TRUE(part);
    EXPECT_EQ(part->spec().height, 512);
    EXPECT_EQ(run("render hole.toml --time-limit never").status, 2);
    EXPECT_EQ(run("render hole.toml --time-limit 0").status, 2);
}

// The signal USR1 requests a snapshot.
TEST_F(Cli, WritesASnapshotAndContinues) {
    write("snapshot.sh",
          "\"$@\" 2>log & until grep -q loaded log; do kill -0 $! || break; sleep 0.05; done; kill -USR1 $!\n"
          "until test -s part.exr; do kill -0 $! || break; sleep 0.05; done; cp part.exr early.exr; wait $!\n");
    const Outcome outcome = run(
        "render hole.toml --size 2048x2048 -D integrator.step=0.001 --threads 2 -o part.exr --time-limit 3 --verbose",
        "sh snapshot.sh");
    EXPECT_EQ(outcome.status, 0) << outcome.err << read("log");
    EXPECT_NE(read("log").find("a snapshot is in part.exr"), std::string::npos) << read("log");
    const auto early = OIIO::ImageInput::open((directory_ / "early.exr").string());
    ASSERT_TRUE(early);
    EXPECT_EQ(early->spec().width, 2048);
}

TEST_F(Cli, AcceptsScheduleNames) {
    EXPECT_EQ(run("render hole.toml --quiet --schedule scanline").status, 0);
    EXPECT_NE(run("render hole.toml --schedule predictd").err.find("predicted"), std::string::npos);
    const json report = json::parse(run("render hole.toml --quiet --schedule tiles --json --threads 2").out);
    EXPECT_EQ(report["schedule"], "tiles");
    ASSERT_EQ(report["thread_times"].size(), 2u);
    for (const json& time : report["thread_times"]) {
        EXPECT_GE(time["busy"], 0.0);
        EXPECT_LE(time["busy"], 1.0);
        EXPECT_LE(time["idle_at_end"], 1.0);
    }
}

TEST_F(Cli, WritesMapsOfLayers) {
    ASSERT_EQ(run("render hole.toml --quiet --size 64x48 --layers color,steps,energy_error --maps -o a.png").status,
              0);
    EXPECT_EQ(files(), (std::set<std::string>{"hole.toml", "a.png", "a-steps.png", "a-energy_error.png"}));
    const Outcome none = run("render hole.toml --quiet --layers color --maps -o a.png");
    EXPECT_EQ(none.status, 2);
    EXPECT_NE(none.err.find("no layer of numbers"), std::string::npos) << none.err;
}

}  // namespace
}  // namespace kagero::test
