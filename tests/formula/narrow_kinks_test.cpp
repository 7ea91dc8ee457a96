// Rays that cross two kinks in one step: thin layers, and chords of a lens close to its edge. Snell's law and the focus
// of the Luneburg lens give the directions behind them.
#include "tests/support/plan_fixture.h"
#include "tests/support/program.h"

#include "tuning/resolve.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kagero::test {
namespace {

class NarrowKinks : public ProgramTest {
protected:
    /// Returns the ends of rays with the default settings of a list.
    static std::vector<RayEnd> trace_list(const std::string& scene, const std::vector<RayInput>& rays,
                                          const Overrides& overrides = {}) {
        const Options options;
        auto plan = plan_of_text(scene +
                                     "[camera]\nposition = [-25, 0, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n"
                                     "[film]\nsize = [16, 12]\n",
                                 overrides, options, false);
        const Plan tuned = tune(std::move(*plan), options, Purpose::ray_list);
        std::vector<RayEnd> ends;
        trace(tuned, start_rays(tuned, rays), ends);
        return ends;
    }
};

/// A layer in which the index grows from 1 to 1 + change over a width.
std::string layer(const std::string& profile, double change, double width) {
    std::ostringstream text;
    text << "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - n^2)\"\n[space.let]\nu = \"x/" << width
         << "\"\nn = \"1 + " << change << "*" << profile << "\"\n";
    return text.str();
}

// The index of a weak layer changes H by less than any bound on the energy error.
TEST_F(NarrowKinks, ThinLayersRefract) {
    for (const double radius : {50.0, 1000.0})
        for (const double width : {1e-2, 1e-3, 1e-4})
            for (const double change : {1e-6, 2e-4, 1e-2})
                for (const std::string overrides : {"integrator.method=dp8", "integrator.method=rkf78", ""}) {
                    // The fixed step is 2 in the larger space; it misses layers thinner than 1/2000 of this.
                    if (radius > 100 && width < 1e-3 && overrides == "integrator.method=dp8") continue;
                    Overrides all{"integrator.escape_radius=" + std::to_string(radius)};
                    if (!overrides.empty()) all.emplace_back(overrides);
                    for (const double slope : {0.5, 0.1, -1.0}) {
                        const RayEnd end =
                            trace_list(layer("min(1, max(0, u))", change, width), {{{-25, 0.3, 0}, {1, slope, 0}}}, all)
                                .front();
                        const double sine = slope / std::sqrt(1 + slope * slope) / (1 + change);
                        EXPECT_NEAR(end.v[1], sine, 1e-8) << overrides << ' ' << change << ' ' << width;
                    }
                }
}

// All rays of a Luneburg lens of radius 1 along x leave through (1, 0, 0), also those that pass close to its edge.
TEST_F(NarrowKinks, ChordsCloseToTheEdgeAreRefracted) {
    for (const char* form :
         {"max(1, 2 - r^2)", "1 + max(0, 1 - r^2)", "where(1 - r, 2 - r^2, 1)", "1 + 0.5*(1 - r^2 + abs(1 - r^2))"})
        for (const double radius : {3.0, 8.0, 200.0}) {
            const std::string scene = "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - (" +
                                      std::string(form) +
                                      "))\"\n[integrator]\nescape_radius = " + std::to_string(radius) + "\n";
            std::vector<RayInput> rays;
            for (const double b : {0.9, 0.9995, 0.9999, 0.99997, 0.99999, 0.999999})
                for (const double start : {-2.0, -2.3, -2.71}) rays.push_back({{start, b, 0}, {1, 0, 0}});
            const std::vector<RayEnd> ends = trace_list(scene, rays, {"camera.position=[-2, 0.1, 0]"});
            for (std::size_t i = 0; i < rays.size(); ++i) {
                const double b = rays[i].position[1];
                EXPECT_EQ(ends[i].status, Status::escaped);
                EXPECT_NEAR(ends[i].v[1], -b, 1e-9 / std::sqrt(1 - b)) << form << ' ' << radius << ", ray " << i;
            }
        }
}

// The sound of a source above a layer of water that is faster by a ten-thousandth.
TEST_F(NarrowKinks, AWeakLayerOfWaterRefracts) {
    const std::string scene =
        "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - (1500/c)^2)\"\n"
        "let = {c = \"1500 + min(0.25, max(0, 0.5*(-z - 100)))\"}\n[integrator]\nescape_radius = 30000\n";
    const RayEnd end = trace_list(scene, {{{0, 0, -99.9}, {1, 0, -1}}},
                                  {"camera.position=[0, 0, -99.9]", "camera.look_at=[1, 0, -100.9]"})
                           .front();
    const double sine = std::sqrt(0.5) * 1500.25 / 1500;
    EXPECT_NEAR(end.v[0], sine, 1e-10);
    EXPECT_NEAR(end.v[2], -std::sqrt(1 - sine * sine), 1e-10);
}

// A smooth layer may be too thin for the steps. H is then not conserved, which is reported with the remedy.
TEST_F(NarrowKinks, LossesOfEnergyAreReported) {
    std::ofstream(directory_ / "thin.toml") << layer("0.5*(1 + tanh(u))", 2e-5, 1e-6)
                                            << "[camera]\nposition = [-25, 0, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n"
                                               "[film]\nsize = [16, 12]\n";
    std::ofstream(directory_ / "rays.csv") << "x,y,z,dx,dy,dz\n-25,0,0,1,0.5,0\n";
    const Outcome outcome = run("trace thin.toml --rays rays.csv");
    EXPECT_EQ(outcome.status, 0);
    EXPECT_NE(outcome.err.find("H is not conserved"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("set space.length_scale"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace kagero::test
