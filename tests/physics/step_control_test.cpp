// Tests adaptive methods in spaces with large uniform regions, where the step length grows. Steps must not pass over a
// narrow inhomogeneity behind such a region.
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kagero::test {
namespace {

std::string scene_of(const std::string& formula) {
    return "[space]\nhamiltonian = \"formula\"\n" + formula +
           "\n[camera]\nposition = [0, 0, 9]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\n[film]\nsize = [4, 4]\n";
}

std::vector<RayEnd> ends_of(const std::string& scene, const Overrides& overrides, const std::vector<RayInput>& rays) {
    const auto plan = plan_of_text(scene, overrides, with_strategy("packet"), false);
    std::vector<RayEnd> ends;
    trace(*plan, start_rays(*plan, rays), ends);
    return ends;
}

// A thin layer separates two uniform half spaces: N² = 1.5 + 0.5 tanh 4z. p_x, p_y and |p|² − N² are conserved, so that
// Snell's law determines the end. The step length in the half spaces is practically unlimited.
TEST(UniformHalfSpaces, LayerBetweenThemObeysSnellsLaw) {
    const std::string layer =
        scene_of("H = \"(px^2 + py^2 + pz^2 - 1.5 - 0.5*tanh(4*z))/2\"\nlength_scale = \"100\"\n");
    std::vector<RayInput> rays;
    for (int i = 0; i < 4000; ++i) {
        const double cosine = std::cos(i * 2.3999) * 0.97, azimuth = i * 1.0, distance = 6 + 3 * std::cos(i * 0.37),
                     sine = std::sqrt(1 - cosine * cosine);
        const Double3 d{sine * std::cos(azimuth), sine * std::sin(azimuth), cosine};
        rays.push_back({{-distance * d[0], -distance * d[1], -distance * d[2]}, d});
    }
    // rkf78 is left out. Its error estimate uses only derivatives at the ends of the step, and is small if both ends
    // are in uniform regions. Some of its steps pass over the layer, so that H is not preserved.
    for (const char* method : {"dp54", "dp85"}) {
        const auto ends =
            ends_of(layer, {"integrator.method=" + std::string(method), "integrator.tolerance=1e-10"}, rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const auto& [q, d] = rays[i];
            if (std::abs(q[2]) < 3) continue;  // the start is in the layer or close to it
            // N² at the start and on the other side of the layer.
            const double n2_start = q[2] < 0 ? 1 : 2, n2_beyond = 3 - n2_start;
            const double transverse2 = n2_start * (d[0] * d[0] + d[1] * d[1]);  // p_x² + p_y²
            if (std::abs(transverse2 - n2_beyond) < 0.02) continue;  // near the critical angle
            const double pz = transverse2 < n2_beyond ? std::copysign(std::sqrt(n2_beyond - transverse2), d[2])
                                                      : -std::sqrt(n2_start - transverse2) * (d[2] < 0 ? -1 : 1);
            ASSERT_EQ(ends[i].status, Status::escaped) << method << ", ray " << i;
            EXPECT_NEAR(ends[i].p[2], pz, 1e-3) << method << ", ray " << i;
        }
    }
}

class StepControl : public testing::TestWithParam<const char*> {};

// Rays start at the distance 12 from an inhomogeneity of radius 0.7. The step length is bounded by the distance from
// the centre. The reference is a symplectic method with a fixed short step.
TEST_P(StepControl, StepsDoNotPassOverANarrowInhomogeneity) {
    const std::string scene = scene_of("H = \"(px^2 + py^2 + pz^2 - (1 + 0.6*exp(-4*(x^2 + y^2 + z^2)))^2)/2\"\n");
    std::vector<RayInput> rays;
    for (int i = 0; i < 200; ++i) {
        const double cosine = 0.99 - 0.0099 * i, azimuth = 2.3999 * i, sine = std::sqrt(1 - cosine * cosine),
                     impact = 0.005 * i;
        const Double3 d{sine * std::cos(azimuth), sine * std::sin(azimuth), cosine},
            normal{-std::sin(azimuth), std::cos(azimuth), 0};
        rays.push_back({{impact * normal[0] - 12 * d[0], impact * normal[1] - 12 * d[1], -12 * d[2]}, d});
    }
    const auto reference = ends_of(scene, {"integrator.method=gauss8", "integrator.step=0.05"}, rays);
    double greatest_deflection = 0;
    for (const char* tolerance : {"1e-3", "1e-6", "1e-10"}) {
        const auto ends =
            ends_of(scene,
                    {"integrator.method=" + std::string(GetParam()), std::string("integrator.tolerance=") + tolerance},
                    rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_EQ(ends[i].status, Status::escaped);
            for (int k = 0; k < 3; ++k) {
                EXPECT_NEAR(ends[i].p[k], reference[i].p[k], 2e-5) << "ray " << i << ", tolerance " << tolerance;
                greatest_deflection = std::max(greatest_deflection, std::abs(reference[i].p[k] - rays[i].direction[k]));
            }
        }
    }
    EXPECT_GT(greatest_deflection, 0.5);
}

INSTANTIATE_TEST_SUITE_P(Adaptive, StepControl, testing::Values("dp54", "dp85", "rkf78"),
                         [](const auto& chosen) { return std::string(chosen.param); });

}  // namespace
}  // namespace kagero::test
