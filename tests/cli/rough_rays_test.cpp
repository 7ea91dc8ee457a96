// Tests of rays with invalid or extreme numbers: such rays must fail with a reason, without any effect on other rays.
#include "tests/support/program.h"

#include <algorithm>

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
[film]
size = [8, 8]
)";

constexpr const char* walls = R"([[object]]
name = "room"
shape = "room"
min = [-1, -1, -1]
max = [1, 1, 1]
[[object]]
name = "ball"
shape = "sphere"
center = [0.5, 0.5, 0]
radius = 0.2
)";

constexpr const char* header = "x,y,z,dx,dy,dz\n";

constexpr const char* ordinary[] = {"0.1,-0.9,0.1,0.1,1,0", "-0.9,0.3,0,1,0,0", "0,-0.9,0.1,0,1,-0.1",
                                    "0,0.9,0,0.5,-1,0",     "0.3,0.1,0,-1,0,0", "0.5,0,0,0,1,0.01",
                                    "0,0,0.7,0.3,0,-1",     "0.2,0.2,0.2,1,1,1"};

/// Rays that must fail.
constexpr const char* invalid[] = {"nan,0,0,1,0,0",    "0.5,0,nan,1,0,0", "0.5,0,0,nan,0,0", "inf,0,0,1,0,0",
                               "0.5,0,0,0,-inf,0", "0.5,0,0,0,0,0",   "0,0,0,1,0,0",     "-0.9,0.1,0,inf,inf,inf"};

/// Rays that may end normally or fail, because numbers can overflow.
constexpr const char* extreme[] = {"1e300,0,0,1,0,0",    "1e300,0,0,-1,0,0", "-1e300,1e300,1e300,1,-0.2,0",
                               "1e160,0,0,-1,0.1,0", "1e30,0,0,-1,0,0",  "0,1e19,0,0,-1,0",
                               "0,1e9,0,0.001,-1,0", "1e-300,0,0,1,0,0", "0,0,1e150,0,0,-1",
                               "0.04,0,0,1,0,0.2",   "0.02,0,0,0,1,0"};

/// A row of the output of `trace`. `without_ray_number` is the row without its first column.
struct Row {
    std::string status, without_ray_number, reason;
};

std::vector<Row> rows_of(const std::string& csv) {
    std::vector<Row> rows;
    for (const std::string& line : lines_of(csv)) {
        const std::size_t first = line.find(','), second = line.find(',', first + 1);
        const bool quoted = line.back() == '"';
        const std::size_t last = quoted ? line.rfind(",\"") : line.rfind(',');
        rows.push_back({line.substr(first + 1, second - first - 1), line.substr(first), line.substr(last + 1)});
    }
    rows.erase(rows.begin());
    return rows;
}

bool all_numbers_finite(const std::string& row) {
    return row.find("nan") == std::string::npos && row.find("inf") == std::string::npos;
}

/// The parameter is a scene and options of `trace`.
class ExtremeRays : public ProgramTest, public testing::WithParamInterface<std::pair<const char*, const char*>> {
protected:
    void SetUp() override {
        ProgramTest::SetUp();
        write("empty.toml", room);
        write("walls.toml", std::string(room) + walls);
    }
    std::vector<Row> trace(const std::string& rays) const {
        write("rays.csv", header + rays);
        const Outcome outcome = run(std::string("trace ") + GetParam().first + " --rays rays.csv " + GetParam().second);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return outcome.status == 0 ? rows_of(outcome.out) : std::vector<Row>{};
    }
};

// The ordinary rays are traced with and without the invalid and extreme rays. The lanes of the ordinary rays differ,
// but their rows must be equal.
TEST_P(ExtremeRays, FailWithAReasonAndDoNotChangeOtherRays) {
    std::string mixed, alone;
    std::vector<const char*> rays;
    const auto add = [&](const char* ray) {
        mixed += ray + std::string("\n");
        rays.push_back(ray);
    };
    constexpr std::size_t ordinary_count = std::size(ordinary),
                          count = std::max({ordinary_count, std::size(invalid), std::size(extreme)});
    for (std::size_t i = 0; i < count; ++i) {
        add(invalid[i % std::size(invalid)]);
        add(ordinary[i % ordinary_count]);
        add(extreme[i % std::size(extreme)]);
        alone += ordinary[i % ordinary_count] + std::string("\n");
    }
    const auto with = trace(mixed), without = trace(alone);
    ASSERT_EQ(with.size(), rays.size());
    ASSERT_EQ(without.size(), count);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        SCOPED_TRACE(std::string(rays[i]) + " -> " + with[i].without_ray_number);
        const bool failed = with[i].status == "failed";
        EXPECT_TRUE(failed ? !with[i].reason.empty() : all_numbers_finite(with[i].without_ray_number));
        if (i % 3 == 2) continue;  // i % 3 is 0 for invalid, 1 for ordinary and 2 for extreme rays
        EXPECT_EQ(failed, i % 3 == 0);
        EXPECT_TRUE(failed || with[i].without_ray_number == without[i / 3].without_ray_number);
    }
}

INSTANTIATE_TEST_SUITE_P(Spaces, ExtremeRays,
                         testing::Values(std::pair{"empty.toml", ""}, std::pair{"walls.toml", ""},
                                         std::pair{"walls.toml", "--strategy scalar"},
                                         std::pair{"walls.toml", "-D integrator.cull=none -D integrator.max_steps=200"},
                                         std::pair{"walls.toml",
                                                   "-D integrator.rescale=none -D integrator.max_steps=200"},
                                         std::pair{"walls.toml", "-D space.rg=0"}));

TEST_F(ProgramTest, EndsEveryRayWithHugeSteps) {
    write("scene.toml", std::string(room) + walls);
    for (const char* options : {"", "-D integrator.rescale=none", "--integrator rk4", "--integrator verlet"}) {
        const Outcome outcome = run(std::string("render scene.toml -o a.png --json --quiet --step 1e3 ") + options);
        EXPECT_EQ(outcome.status, 0) << options << outcome.err;
        EXPECT_NE(outcome.out.find("\"rays\": 64"), std::string::npos) << outcome.out;
    }
}

TEST_F(ProgramTest, EndsRaysAtTheStepLimit) {
    write("scene.toml", room);
    write("rays.csv", std::string(header) + "0,-0.9,0,1,0.2,0\n0,-0.9,0,0,1,0.3\n0,-0.9,0,0,-1,0\n");
    const Outcome outcome = run("trace scene.toml --rays rays.csv --step 0.01 -D integrator.max_steps=3");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    for (const Row& row : rows_of(outcome.out)) {
        EXPECT_EQ(row.status, "step_limit");
        EXPECT_TRUE(all_numbers_finite(row.without_ray_number));
        EXPECT_EQ(row.reason, "the ray did not end within integrator.max_steps = 3");
    }
}

}  // namespace
}  // namespace kagero::test
