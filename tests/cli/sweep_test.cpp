// Tests of `kagero sweep` without MPI: rows, values, refusals, and sweeps that continue.
#include "tests/support/hole_scene.h"

namespace kagero::test {
namespace {

class SweepVerb : public HoleTest {
protected:
    void SetUp() override {
        HoleTest::SetUp();
        write("rays.csv", "x,y,z,dx,dy,dz\n-2,0.5,0,1,0,0\n-2,0.8,0.1,1,0,0\n-2,1,0,1,0,0\n");
    }
    /// Returns the rows of a CSV without its header.
    static std::vector<std::string> rows_of(const std::string& text) {
        std::vector<std::string> lines = lines_of(text);
        lines.erase(lines.begin());
        return lines;
    }
};

// The rows of a set are those that `trace` writes for a scene with the values of the set.
TEST_F(SweepVerb, WritesTheRowsOfEachSet) {
    const Outcome swept =
        run("sweep hole.toml --vary space.rg=0.05:0.2:4 --vary integrator.escape_radius=20,25,30,35 "
            "--rays rays.csv");
    ASSERT_EQ(swept.status, 0) << swept.err;
    const std::vector<std::string> rows = rows_of(swept.out);
    ASSERT_EQ(rows.size(), 12u);
    EXPECT_EQ(lines_of(swept.out)[0].find("set,space.rg,integrator.escape_radius,ray,status,object,x,"), 0u);
    const Outcome traced = run("trace hole.toml -D space.rg=0.15 -D integrator.escape_radius=30 --rays rays.csv");
    const std::vector<std::string> expected = rows_of(traced.out);
    for (std::size_t i = 0; i < 3; ++i)
        EXPECT_EQ(rows[6 + i].substr(rows[6 + i].find(",30,") + 4), expected[i]) << rows[6 + i];
}

// Values are numbers, words, strings in quotes and arrays, as for -D.
TEST_F(SweepVerb, VariesKeysOfAnyType) {
    const Outcome swept =
        run("sweep hole.toml --vary integrator.method=dp85,gauss8 --vary 'space.center=[0,0,0],[0, 0.25, 0]' --rays "
            "rays.csv");
    ASSERT_EQ(swept.status, 0) << swept.err;
    const std::vector<std::string> rows = rows_of(swept.out);
    ASSERT_EQ(rows.size(), 6u);
    const std::string expected_prefix = "1,gauss8,\"[0, 0.25, 0]\",";
    const std::vector<std::string> expected =
        rows_of(run("trace hole.toml -D integrator.method=gauss8 -D 'space.center=[0, 0.25, 0]' --rays rays.csv").out);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(rows[3 + i], expected_prefix + expected[i]);
}

// A formula may begin with a digit. Those with commas are in quotes, as for -D.
TEST_F(SweepVerb, VariesFormulas) {
    write("lens.toml",
          "[space]\nhamiltonian = \"formula\"\nH = \"k*(px^2 + py^2 + pz^2 - n^2)\"\n[space.let]\nk = \"0.5\"\n"
          "n = \"2\"\n[integrator]\nescape_radius = 5\n");
    const std::string trace = "trace lens.toml --rays rays.csv -D space.let.n=", one = "\"1+max(0.1, x^2/9)\"",
                      two = "2*exp(-x^2)+0.5";
    const Outcome swept = run("sweep lens.toml --vary 'space.let.n=" + one + "," + two + "' --rays rays.csv");
    ASSERT_EQ(swept.status, 0) << swept.err;
    const std::vector<std::string> rows = rows_of(swept.out);
    ASSERT_EQ(rows.size(), 6u);
    const auto expect = [&](const std::string& formula, std::size_t first) {
        const Outcome traced = run(trace + "'" + formula + "'");
        ASSERT_EQ(traced.status, 0) << traced.err;
        const std::vector<std::string> expected = rows_of(traced.out);
        for (std::size_t i = 0; i < 3; ++i)
            EXPECT_TRUE(rows[first + i].ends_with("," + expected[i])) << rows[first + i];
    };
    expect(one, 0);
    expect(two, 3);
}

// The reasons in the rows of a set are those of its own scene.
TEST_F(SweepVerb, StatesTheReasonsOfEachSet) {
    const Outcome swept = run("sweep hole.toml --vary integrator.max_steps=1000,3 --rays rays.csv");
    ASSERT_EQ(swept.status, 0) << swept.err;
    const std::vector<std::string> rows = rows_of(swept.out);
    for (std::size_t i = 3; i < 6; ++i)
        EXPECT_NE(rows.at(i).find("the ray did not end within integrator.max_steps = 3"), std::string::npos) << rows[i];
}

// The rows of a block do not depend on the other blocks: 5000 rays are divided, 500 are not.
TEST_F(SweepVerb, DoesNotDependOnTheDivisionIntoBlocks) {
    std::string many = "x,y,z,dx,dy,dz\n", few = many;
    for (int i = 0; i < 5000; ++i) {
        const std::string ray = "-2," + std::to_string(0.0005 * (i - 2500)) + ",0.3,1,0,0\n";
        many += ray;
        if (i < 500) few += ray;
    }
    write("many.csv", many);
    write("few.csv", few);
    const Outcome all = run("sweep hole.toml --vary space.rg=0.05,0.1,0.2 --rays many.csv --json report.json -o a.csv");
    ASSERT_EQ(all.status, 0) << all.err;
    EXPECT_EQ(read("report.json").find("\"blocks\": 1,"), std::string::npos) << "the sweep is not divided";
    const std::vector<std::string> rows = rows_of(read("a.csv")),
                                   some =
                                       rows_of(run("sweep hole.toml --vary space.rg=0.05,0.1,0.2 --rays few.csv").out);
    ASSERT_EQ(rows.size(), 15000u);
    ASSERT_EQ(some.size(), 1500u);
    for (std::size_t set = 0; set < 3; ++set)
        for (std::size_t i = 0; i < 500; ++i) ASSERT_EQ(rows[5000 * set + i], some[500 * set + i]);
}

TEST_F(SweepVerb, RefusesWrongValues) {
    const std::vector<std::pair<std::string, std::string>> refusals{
        {"--rays rays.csv", "a sweep needs a key and its values"},
        {"--vary space.rg --rays rays.csv", "'space.rg' is not KEY=VALUES"},
        {"--vary space.rg=0:1 --rays rays.csv", "'0:1' is neither a list V1,V2,... nor a range A:B:N"},
        {"--vary space.rg=0:1:1 --rays rays.csv", "'1' is out of range; it must be from 2 to"},
        {"--vary space.rg=0,x --rays rays.csv", "set 1 of the sweep: -D space.rg=x: space.rg = \"x\" is not legal"},
        {"--vary space.rg=0,1e --rays rays.csv", "--vary space.rg: '1e' is not a finite number"},
        {"--vary space.rg=0,nan --rays rays.csv", "--vary space.rg: 'nan' is not a finite number"},
        {"--vary 'space.let.n=1+max(0.1,x),2' --rays rays.csv", "-D space.let.n=1+max(0.1,x): Error while parsing"},
        {"--vary space.rg=0,,1 --rays rays.csv", "'0,,1' contains an empty value"},
        {"--vary space.rg= --rays rays.csv", "'' contains an empty value"},
        {"--vary integrator.method=dp85,gaus8 --rays rays.csv", "set 1 of the sweep: -D integrator.method=gaus8"},
        {"--vary integrator.escape_radius=20,-1 --rays rays.csv", "set 1 of the sweep: "},
        {"--vary space.rg=0.1,-1 --rays rays.csv", "rg"},
        {"--vary space.rh=0.1,0.2 --rays rays.csv", "set 0 of the sweep: "},
        {"--vary space.rg=0.1,0.2 --vary camera.fov=40 --rays rays.csv", "camera.fov has 1 value, but space.rg has 2"},
        {"--vary space.rg=0.1 --vary space.rg=0.2 --rays rays.csv", "space.rg occurs twice"},
        {"--vary space.rg=0.1,0.2 --rays missing.csv", "cannot read the rays 'missing.csv'"},
        {"--vary space.rg=0.1,0.2 --rays rays.csv --resume", "state a file for it with -o FILE"},
        {"--vary space.rg=0.1,0.2 --rays rays.csv -o rays.csv", "are the same file"},
    };
    for (const auto& [arguments, reason] : refusals) {
        const Outcome outcome = run("sweep hole.toml " + arguments);
        EXPECT_EQ(outcome.status, 2) << arguments << ": " << outcome.err;
        EXPECT_NE(outcome.err.find(reason), std::string::npos) << outcome.err;
        EXPECT_EQ(outcome.out, "") << arguments;
    }
}

TEST_F(SweepVerb, WarnsOfKeysWithoutEffect) {
    const Outcome outcome =
        run("sweep hole.toml --vary camera.fov=10,20 --vary space.rg=0.1,0.2 --rays rays.csv -o a.csv --json a.json");
    EXPECT_EQ(outcome.status, 0);
    const std::string remark = "camera.fov has no effect on this sweep: rays of a list do not start at the camera";
    EXPECT_NE(outcome.err.find("warning: " + remark), std::string::npos) << outcome.err;
    EXPECT_NE(read("a.json").find(remark), std::string::npos);
    EXPECT_EQ(outcome.err.find("space.rg"), std::string::npos) << outcome.err;
}

TEST_F(SweepVerb, ContinuesFromItsJournal) {
    std::string rays = "x,y,z,dx,dy,dz\n";
    for (int i = 0; i < 500; ++i) rays += "-2," + std::to_string(0.005 * (i - 250)) + ",0.3,1,0,0\n";
    write("rays.csv", rays);
    const std::string sweep =
        "sweep hole.toml --vary space.rg=0.05:0.2:40 --rays rays.csv --integrator gauss8 --step 0.01 --threads 1 ";
    ASSERT_EQ(run(sweep + "-o whole.csv").status, 0);
    std::ofstream(output_ / "kill.sh") << "\"$@\" & while kill -0 $! 2>/dev/null; do [ $(stat -c %s a.csv.journal "
                                          "2>/dev/null || echo 0) -gt 500000 ] && break; sleep 0.01; done\n"
                                          "kill -KILL $! 2>/dev/null; wait $!\n";
    run(sweep + "--resume -o a.csv", "sh '" + (output_ / "kill.sh").string() + "'");
    ASSERT_TRUE(exists("a.csv.journal"));
    const Outcome other = run(sweep + "--resume -o a.csv --vary integrator.escape_radius=40:60:40");
    EXPECT_EQ(other.status, 2);
    EXPECT_NE(other.err.find("the journal belongs to another run"), std::string::npos) << other.err;
    const Outcome locked = run(sweep + "--resume -o a.csv", "flock a.csv.journal");
    EXPECT_EQ(locked.status, 2);
    EXPECT_NE(locked.err.find("another process uses the journal 'a.csv.journal'"), std::string::npos) << locked.err;
    const Outcome full = run(sweep + "--resume -o a.csv", "trap '' XFSZ; ulimit -f 600;");
    EXPECT_EQ(full.status, 1);
    EXPECT_NE(full.err.find("cannot write the journal 'a.csv.journal'"), std::string::npos) << full.err;
    const Outcome rest = run(sweep + "--resume -o a.csv");
    ASSERT_EQ(rest.status, 0) << rest.err;
    EXPECT_NE(rest.err.find("continues from a.csv.journal"), std::string::npos) << rest.err;
    EXPECT_TRUE(read("a.csv") == read("whole.csv"));
    EXPECT_FALSE(exists("a.csv.journal"));
}

}  // namespace
}  // namespace kagero::test
