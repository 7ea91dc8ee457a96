// Tests of the columns that the program writes on request: integrals along rays.
#include "tests/support/hole_scene.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

namespace kagero::test {
namespace {

using nlohmann::json;
using Columns = HoleTest;

// The last row of a pixel's path has the integrals that the layers of the picture show, within the accuracy of floats.
TEST_F(Columns, AreWrittenAlongThePathOfAPixel) {
    const std::string accuracy = " --integrator dp85 --tolerance 1e-12";
    const Outcome outcome = run("render hole.toml --pixel 3,2 --columns action,time" + accuracy);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto lines = lines_of(outcome.out);
    ASSERT_GE(lines.size(), 3u);
    EXPECT_EQ(lines[0], "ray,step,parameter,x,y,z,dx,dy,dz,px,py,pz,pt,energy,action,time");
    const auto columns_of = [](const std::string& line) {
        std::vector<double> numbers;
        std::istringstream in(line);
        for (std::string field; std::getline(in, field, ',');) numbers.push_back(std::stod(field));
        return numbers;
    };
    const std::vector<double> first = columns_of(lines[1]), last = columns_of(lines.back());
    ASSERT_EQ(last.size(), 16u);
    EXPECT_EQ(first[14], 0);
    EXPECT_EQ(first[15], 0);
    // H is quadratic in (p, p_t), so that the action is −p_t times the time; light that is followed backward needs at
    // least the time of the straight line between the ends.
    EXPECT_NEAR(last[14], -last[12] * last[15], 1e-6 * last[14]);
    const double distance = std::hypot(last[3] - first[3], last[4] - first[4], last[5] - first[5]);
    EXPECT_GT(last[14], distance);
    EXPECT_LT(last[14], 1.2 * distance);
    // `trace` gives the same numbers for the same ray.
    std::ostringstream ray;
    ray.precision(17);
    ray << "x,y,z,dx,dy,dz\n"
        << first[3] << ',' << first[4] << ',' << first[5] << ',' << first[6] << ',' << first[7] << ',' << first[8]
        << '\n';
    write("rays.csv", ray.str());
    const json traced = json::parse(run("trace hole.toml --rays rays.csv --columns action,time --json" + accuracy).out);
    EXPECT_NEAR(traced["action"][0].get<double>() * last[12], last[14], 1e-6 * last[14]);
    EXPECT_NEAR(traced["time"][0].get<double>(), last[15], 1e-6 * last[14]);
}

}  // namespace
}  // namespace kagero::test
