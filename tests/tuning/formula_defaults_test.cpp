// Tests that a formula whose scene states neither method nor step is integrated correctly, in any unit of length. The
// references are closed forms, quadratures and a compiled space.
#include "tests/support/plan_fixture.h"
#include "tests/support/program.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

namespace kagero::test {
namespace {

using nlohmann::json;

class FormulaDefaults : public ProgramTest {
protected:
    /// Traces one ray and returns the columns of its end from `x` to `energy_error`, after the columns of text.
    std::vector<double> end_of(const std::string& scene, const std::string& ray) const {
        write("scene.toml", scene);
        write("rays.csv", "x,y,z,dx,dy,dz\n" + ray + "\n");
        const Outcome outcome = run("trace scene.toml --rays rays.csv");
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_EQ(outcome.err, "");
        std::istringstream row(lines_of(outcome.out).at(1));
        std::vector<double> numbers;
        int column = 0;
        for (std::string field; std::getline(row, field, ','); ++column)
            if (column >= 3 && column <= 16) numbers.push_back(std::strtod(field.c_str(), nullptr));
        return numbers;
    }
};

std::string number(double x) {
    std::ostringstream text;
    text.precision(17);
    text << x;
    return text.str();
}

/// Returns a view along +x from a distance of 5 units of length.
std::string view_at(double unit) {
    return "[camera]\nposition = [" + number(-5 * unit) +
           ", 0, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [16, 12]\n";
}

// The invisible lens of Leonhardt (2006): a ray turns around the centre once and leaves on the line on which it came.
// Its index is 1 outside r = 1, where the derivative of H jumps. The tolerance of a step is 1e-10, and the rays take a
// few hundred steps.
TEST_F(FormulaDefaults, AnInvisibleLensInAnyUnitLeavesRaysAsTheyCame) {
    for (const double unit : {1e-3, 1.0, 1e3}) {
        SCOPED_TRACE(unit);
        const std::string scene =
            "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - max(1, n^2))\"\n[space.constants]\n"
            "a = " + number(unit) + "\n[space.let]\nr = \"sqrt(x^2 + y^2 + z^2)/a\"\n"
            "Q = \"(-1/r + sqrt(1/r^2 + 1/27))^(1/3)\"\nn = \"(Q - 1/(3*Q))^2\"\n[integrator]\nescape_radius = " +
            number(10 * unit) + "\n" + view_at(unit);
        for (const double b : {0.9, 0.99}) {
            const auto end = end_of(scene, number(-5 * unit) + "," + number(b * unit) + ",0,1,0,0");
            EXPECT_NEAR(end.at(1), b * unit, 1e-6 * unit);
            EXPECT_NEAR(end.at(3), 1, 1e-7);
            EXPECT_NEAR(end.at(4), 0, 1e-7);
        }
    }
}

// Light through a jet of hot air, whose radius a is a three-hundredth of the escape radius. To first order in the
// change of the index, the deflection is 2 δ √π (x/a) exp(−x²/a²) / n. The second order is smaller by the factor
// δ = 1e-4.
TEST_F(FormulaDefaults, AJetMuchNarrowerThanTheSceneDeflectsLight) {
    for (const double unit : {1e-3, 1.0, 1e3}) {
        SCOPED_TRACE(unit);
        const double a = 0.01, x = 0.00707, n = 1.00027;
        const std::string scene =
            "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - n^2)\"\n[space.constants]\na = " +
            number(a * unit) + "\ny0 = " + number(0.05 * unit) + "\n[space.let]\n"
            "n = \"1 + 2.7e-4 - 1e-4*exp(-(x^2 + (y - y0)^2)/a^2)\"\n[integrator]\nescape_radius = " +
            number(3 * unit) + "\n[camera]\nposition = [0, " + number(-unit) +
            ", 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\nfov = 0.3\n[film]\nsize = [32, 24]\n";
        const auto end = end_of(scene, number(x * unit) + "," + number(-unit) + ",0,0,1,0");
        const double deflection = 2e-4 * std::sqrt(M_PI) * (x / a) * std::exp(-x * x / (a * a)) / n;
        EXPECT_NEAR(end.at(3), deflection, 1e-3 * deflection);
    }
}

// A formula for Schwarzschild's spacetime is compared with the compiled space, which is integrated by another method.
TEST_F(FormulaDefaults, AFormulaOfABlackHoleInAnyUnitMatchesTheCompiledSpace) {
    const auto direction = [&](const std::string& space, double unit, const char* more) {
        const std::string scene = space + "[integrator]\nescape_radius = " + number(100 * unit) + "\n" + more +
                                  view_at(2 * unit);
        const auto end = end_of(scene, number(-10 * unit) + "," + number(4 * unit) + "," + number(unit) + ",1,0,0");
        return Double3{end.at(3), end.at(4), end.at(5)};
    };
    const Double3 expected =
        direction("[space]\nhamiltonian = \"schwarzschild\"\nrg = 1\n", 1, "method = \"gauss16\"\nstep = 0.05\n");
    for (const double unit : {1e-3, 1.0, 1e3}) {
        SCOPED_TRACE(unit);
        const std::string formula =
            "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - pt^2) - 0.5*rg/r*(pt + (x*px + y*py + "
            "z*pz)/r)^2\"\ncapture = \"r - rg\"\n[space.constants]\npt = 1\nrg = " + number(unit) +
            "\n[space.let]\nr = \"sqrt(x^2 + y^2 + z^2)\"\n";
        const Double3 actual = direction(formula, unit, "");
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(actual[k], expected[k], 1e-8);
    }
}

// The sound channel of two layers with linear speeds. In each layer, a path is an arc of a circle. The depth at 100 km
// follows from 44 such arcs; it was computed with 40 digits.
TEST_F(FormulaDefaults, ASoundChannelWithAKinkKeepsTheDepthOfTheExactPath) {
    const std::string scene =
        "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - (1500/c)^2)\"\n[space.let]\nd = \"-z\"\n"
        "c = \"max(1540 - 0.05*d, 1490 + 0.015*(d - 1000))\"\n[integrator]\nescape_radius = 1e6\n[camera]\n"
        "position = [0, 0, -1000]\nlook_at = [1, 0, -1000]\nup = [0, 0, 1]\n[film]\nsize = [16, 12]\n[[object]]\n"
        "name = \"range\"\nshape = \"rectangle\"\norigin = [100000, -10000, -10000]\nedge_u = [0, 20000, 0]\n"
        "edge_v = [0, 0, 20000]\n";
    const auto end = end_of(scene, "0,0,-1000,0.99984769515639123,0,0.017452406437283512");
    EXPECT_NEAR(end.at(2), -996.99565, 1e-3);
}

// A picture that states nothing must equal the picture with a small tolerance: a mirage in metres, in a scene of 5 km.
TEST_F(FormulaDefaults, APictureInMetresShowsTheTarget) {
    write("mirage.toml",
          "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - n^2)\"\n[space.let]\n"
          "n = \"1 + 2.7e-4 - 3e-5*exp(-z/0.5)\"\n[integrator]\nescape_radius = 5000\n[camera]\n"
          "position = [0, 0, 1.7]\n"
          "look_at = [3000, 0, 1.7]\nup = [0, 0, 1]\nfov = 0.4\n[film]\nsize = [80, 120]\nlayers = [\"object\"]\n"
          "[[object]]\nname = \"ground\"\nshape = \"rectangle\"\norigin = [-10, -1000, 0]\nedge_u = [5000, 0, 0]\n"
          "edge_v = [0, 2000, 0]\n[[object]]\nname = \"ship\"\nshape = \"rectangle\"\norigin = [3000, -4, 0]\n"
          "edge_u = [0, 8, 0]\nedge_v = [0, 0, 8]\n");
    const auto status = [&](const std::string& options) {
        const Outcome outcome = run("render mirage.toml -o a.exr --json " + options);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return json::parse(outcome.out);
    };
    const json chosen = status(""), fine = status("--tolerance 1e-10 --precision double");
    EXPECT_EQ(chosen["warnings"].size(), 0u) << chosen["warnings"];
    EXPECT_GT(chosen["status"]["hit"], 1000);
    EXPECT_NEAR(double(chosen["status"]["hit"]), double(fine["status"]["hit"]), 0.002 * 80 * 120);
    EXPECT_LT(chosen["gradients"], fine["gradients"]);
}

}  // namespace
}  // namespace kagero::test
