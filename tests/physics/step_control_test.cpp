// Adaptive methods in spaces that are uniform over long ways, where steps grow: what is narrow behind them is not leapt
// over.
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

// N² = 1.5 + 0.5 tanh 4z: px and py stay, and so do |p|² − N² and Snell's law with it. Steps in the uniform halves may
// be as long as they like.
TEST(UniformHalves, LayerBetweenThemRefractsAndReflectsTotally) {
    const std::string layer =
        scene_of("H = \"(px^2 + py^2 + pz^2 - 1.5 - 0.5*tanh(4*z))/2\"\nlength_scale = \"100\"\n");
    std::vector<RayInput> rays;
    for (int i = 0; i < 4000; ++i) {
        const double cosine = std::cos(i * 2.3999) * 0.97, around = i * 1.0, away = 6 + 3 * std::cos(i * 0.37),
                     sine = std::sqrt(1 - cosine * cosine);
        const Double3 d{sine * std::cos(around), sine * std::sin(around), cosine};
        rays.push_back({{-away * d[0], -away * d[1], -away * d[2]}, d});
    }
    for (const char* method :
         {"dp54",
          "dp85"}) {  // Fehlberg's estimate is blind where the ends of a step are alike: a few of these rays lose H
        const auto ends =
            ends_of(layer, {"integrator.method=" + std::string(method), "integrator.tolerance=1e-10"}, rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const auto& [q, d] = rays[i];
            if (std::abs(q[2]) < 3) continue;  // no uniform half to start from
            const double here = q[2] < 0 ? 1 : 2, there = 3 - here, across = here * (d[0] * d[0] + d[1] * d[1]);
            if (std::abs(across - there) < 0.02) continue;  // it lingers at the layer's edge
            const double pz = across < there ? std::copysign(std::sqrt(there - across), d[2])
                                             : -std::sqrt(here - across) * (d[2] < 0 ? -1 : 1);
            ASSERT_EQ(ends[i].status, Status::escaped) << method << ", ray " << i;
            EXPECT_NEAR(ends[i].p[2], pz, 1e-3) << method << ", ray " << i;
        }
    }
}

class StepControl : public testing::TestWithParam<const char*> {};

// A ball of some 0.7 seen from 12: what the method takes for uniform is bounded by the distance from the centre.
// Against a symplectic method of fixed, short steps.
TEST_P(StepControl, DoesNotLeapOverANarrowBall) {
    const std::string ball = scene_of("H = \"(px^2 + py^2 + pz^2 - (1 + 0.6*exp(-4*(x^2 + y^2 + z^2)))^2)/2\"\n");
    std::vector<RayInput> rays;
    for (int i = 0; i < 200; ++i) {
        const double height = 0.99 - 0.0099 * i, around = 2.3999 * i, wide = std::sqrt(1 - height * height),
                     past = 0.005 * i;
        const Double3 d{wide * std::cos(around), wide * std::sin(around), height},
            aside{-std::sin(around), std::cos(around), 0};
        rays.push_back({{past * aside[0] - 12 * d[0], past * aside[1] - 12 * d[1], -12 * d[2]}, d});
    }
    const auto sure = ends_of(ball, {"integrator.method=gauss8", "integrator.step=0.05"}, rays);
    double bent = 0;
    for (const char* tolerance : {"1e-3", "1e-6", "1e-10"}) {
        const auto ends =
            ends_of(ball,
                    {"integrator.method=" + std::string(GetParam()), std::string("integrator.tolerance=") + tolerance},
                    rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_EQ(ends[i].status, Status::escaped);
            for (int k = 0; k < 3; ++k) {
                EXPECT_NEAR(ends[i].p[k], sure[i].p[k], 2e-5) << "ray " << i << ", tolerance " << tolerance;
                bent = std::max(bent, std::abs(sure[i].p[k] - rays[i].direction[k]));
            }
        }
    }
    EXPECT_GT(bent, 0.5);
}

INSTANTIATE_TEST_SUITE_P(Adaptive, StepControl, testing::Values("dp54", "dp85", "rkf78"),
                         [](const auto& each) { return std::string(each.param); });

}  // namespace
}  // namespace kagero::test
