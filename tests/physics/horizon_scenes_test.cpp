// Tests scenes with a camera or objects inside a horizon, and the output of `trace` for such rays, with the program.
#include "tests/support/program.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace kagero::test {
namespace {

/// Fixture that runs the program.
class HorizonScenes : public ProgramTest {
protected:
    /// Writes a scene with one object, which is called "thing".
    void write_scene(const std::string& space, const std::string& camera, const std::string& thing) {
        write("scene.toml", "space = { " + space + " }\n[camera]\nposition = " + camera +
                                "\nlook_at = [0, 0, 0.1]\nup = [0, 0.6, 0.8]\nobserver = \"falling\"\n[film]\n"
                                "size = [8, 8]\n[[object]]\nname = \"thing\"\n" +
                                thing + "\n");
    }
    /// Expects that the program refuses the scene, and that the message contains the texts.
    void expect_refusal(const std::vector<std::string>& texts) {
        for (const char* verb : {"check", "render", "explain"}) {
            const Outcome outcome = run(std::string(verb) + " scene.toml");
            EXPECT_EQ(outcome.status, 2) << verb;
            for (const std::string& text : texts)
                EXPECT_NE(outcome.err.find(text), std::string::npos) << verb << ": " << outcome.err;
        }
    }
};
constexpr const char* kerr = "hamiltonian = \"kerr\", spin = 0.9";  // r₊ = 1.436, |q| ≤ 1.695 on the horizon
constexpr const char* schwarzschild = "hamiltonian = \"schwarzschild\", rg = 2";

TEST_F(HorizonScenes, RefuseObjectsInsideForACameraOutside) {
    for (const char* space : {kerr, schwarzschild}) {
        write_scene(space, "[0, -10, 0]", "shape = \"sphere\"\ncenter = [0.5, 0, 0.3]\nradius = 0.2");
        expect_refusal({"scene.toml:9", "object thing lies inside the horizon", space == kerr ? "r = 1.43" : "r = 2"});
        // A list of rays may start anywhere.
        write("rays.csv", "x,y,z,dx,dy,dz\n0,-10,0,0,1,0\n");
        EXPECT_EQ(run("trace scene.toml --rays rays.csv").status, 0);
    }
}

TEST_F(HorizonScenes, RefuseObjectsThatTouchASpinningHorizonForACameraInside) {
    const char* const things[] = {
        "shape = \"sphere\"\ncenter = [1.6, 0, 0]\nradius = 0.3",
        "shape = \"box\"\nmin = [1.2, -0.1, -0.1]\nmax = [3, 0.1, 0.1]",
        "shape = \"rectangle\"\norigin = [-3, -3, 1.3]\nedge_u = [6, 0, 0]\nedge_v = [0, 6, 0]"};
    for (const char* thing : things) {
        write_scene(kerr, "[0, 0.1, 1]", thing);
        expect_refusal({"object thing touches the horizon of a spinning hole", "r = 1.43"});
        // Without spin, positions are the same in both forms.
        write_scene(schwarzschild, "[0, 0.1, 1]", thing);
        EXPECT_EQ(run("check scene.toml").status, 0) << thing;
    }
    // An object may enclose the hole.
    write_scene(kerr, "[0, 0.1, 1]", "shape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1.8");
    EXPECT_EQ(run("check scene.toml").status, 0);
}

// The camera looks sideways, where the sky has its edge.
TEST_F(HorizonScenes, HaveNoFailedRaysDeepInside) {
    write("deep.toml",
          "space = { hamiltonian = \"schwarzschild\", rg = 1 }\n[integrator]\nescape_radius = 100\n[camera]\n"
          "position = [-0.01, 0, 0]\nlook_at = [-0.01, 1, 0]\nup = [0, 0, 1]\nfov = 30\nobserver = \"falling\"\n"
          "[film]\nsize = [160, 120]\n");
    const Outcome outcome = run("render deep.toml -o deep.exr --quiet --json");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto report = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(int(report["status"]["escaped"]) + int(report["status"]["captured"]), 160 * 120) << report.dump(1);
    EXPECT_EQ(report["warnings"].size(), 0u) << report.dump(1);
}

/// A row of the CSV that `trace` writes.
struct Row {
    std::string status;
    double q[3], v[3], p[3], pt;
};

/// Fixture that traces rays of falling observers.
class FallingRaysInCsv : public ProgramTest {
protected:
    /// Returns the ends of rays with the given starts and directions, or, with the option --path, all their points.
    std::vector<Row> trace(const std::string& space, const std::string& rays, bool path = false) {
        write("hole.toml", "space = { " + space +
                               " }\n[integrator]\nescape_radius = 30\n[camera]\n"
                               "position = [0, -9, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [4, 4]\n");
        write("rays.csv", "x,y,z,dx,dy,dz\n" + rays);
        const Outcome outcome =
            run(std::string("trace hole.toml --rays rays.csv --observer falling") + (path ? " --path" : ""));
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        std::vector<Row> rows;
        for (const std::string& line : lines_of(outcome.out)) {
            if (line.find("ray") == 0) continue;  // the header
            std::istringstream in(line);
            std::vector<std::string> cells;
            for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
            Row row{cells[1], {}, {}, {}, std::stod(cells[12])};
            for (std::size_t k = 0; k < 3; ++k) {
                row.q[k] = std::stod(cells[3 + k]);
                row.v[k] = std::stod(cells[6 + k]);
                row.p[k] = std::stod(cells[9 + k]);
            }
            rows.push_back(row);
        }
        return rows;
    }
};

/// Expects that H of the outgoing Kerr–Schild form is 0, and that ∂H/∂p is along v. Without spin, this is also the
/// time-reversed ingoing form.
void expect_outgoing_form(const Row& row, double mass, double a) {
    const double *q = row.q, *p = row.p, z2 = q[2] * q[2], b = q[0] * q[0] + q[1] * q[1] + z2 - a * a,
                 r2 = 0.5 * (b + std::sqrt(b * b + 4 * a * a * z2)), r = std::sqrt(r2);
    const double f = 2 * mass * r2 * r / (r2 * r2 + a * a * z2);
    const double l[3] = {(r * q[0] - a * q[1]) / (r2 + a * a), (r * q[1] + a * q[0]) / (r2 + a * a), q[2] / r};
    const double w = row.pt + l[0] * p[0] + l[1] * p[1] + l[2] * p[2], p2 = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
    EXPECT_NEAR(0.5 * (p2 - row.pt * row.pt) - 0.5 * f * w * w, 0, 1e-9 * p2);
    const double speed[3] = {p[0] - f * w * l[0], p[1] - f * w * l[1], p[2] - f * w * l[2]};
    const double length = std::hypot(speed[0], speed[1], speed[2]);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(speed[k] / length, row.v[k], 1e-9);
}

// On the axis, a falling observer sees the ray at the angle α from the outward direction with the energy at infinity
// E = 1 + √(2Mr/(r² + a²)) cos α. p_t is E if the ray starts outside the horizon, and −E if it starts inside.
TEST_F(FallingRaysInCsv, HaveTheMomentumOfTheOutgoingFormIfTheyStartOutside) {
    for (const double spin : {0.0, 0.9}) {
        const double horizon = 1 + std::sqrt(1 - spin * spin);
        const std::string space = "hamiltonian = \"kerr\", spin = " + std::to_string(spin);
        for (const double r : {6.0, 2.5, 1.001 * horizon, 0.999 * horizon, 0.7 * horizon})
            for (const double alpha : {0.1, 0.8, 1.4}) {
                std::ostringstream ray;
                ray.precision(17);
                ray << "0,0," << r << ',' << std::sin(alpha) << ",0," << std::cos(alpha) << '\n';
                const double energy = 1 + std::sqrt(2 * r / (r * r + spin * spin)) * std::cos(alpha);
                SCOPED_TRACE(testing::Message() << "spin " << spin << ", r " << r << ", alpha " << alpha);
                const bool inside = r < horizon;
                const auto rows = trace(space, ray.str());
                ASSERT_EQ(rows.size(), 1u);
                EXPECT_EQ(rows[0].status, "escaped");
                EXPECT_NEAR(rows[0].pt, inside ? -energy : energy, 1e-14 * energy);
                if (!inside || spin == 0) expect_outgoing_form(rows[0], 1, spin);
                for (const Row& point : trace(space, ray.str(), true)) EXPECT_EQ(point.pt, rows[0].pt);
            }
    }
}

// Each row is one state of the ray, so that the angular momentum x p_y − y p_x is the same in all rows.
TEST_F(FallingRaysInCsv, ConserveAngularMomentumInAllRows) {
    for (const double spin : {0.0, 0.9})
        for (const char* ray : {"4,0.4,0.3,-1,0.3,0.5\n", "1.7,0.5,0.3,1,0.3,0.5\n", "1,0.4,0.3,1,0.3,0.5\n"}) {
            SCOPED_TRACE(testing::Message() << "spin " << spin << ", ray " << ray);
            const auto rows = trace("hamiltonian = \"kerr\", spin = " + std::to_string(spin), ray, true);
            ASSERT_GT(rows.size(), 10u);
            const auto angular_momentum = [](const Row& row) { return row.q[0] * row.p[1] - row.q[1] * row.p[0]; };
            double greatest = 0;
            for (const Row& row : rows)
                greatest = std::max(greatest, std::abs(angular_momentum(row) - angular_momentum(rows[0])));
            EXPECT_LT(greatest, 1e-7);
        }
}

}  // namespace
}  // namespace kagero::test
