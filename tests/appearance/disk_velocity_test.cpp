// Tests of the velocity of the matter of disks: circular orbits that follow from H, and stated velocities.
#include "tests/support/velocity_scenes.h"


#include <gtest/gtest.h>

#include <cmath>

namespace kagero::test {
namespace {

// The angular velocity that follows from H is compared with the closed form for built-in holes.
TEST(DiskVelocity, OfCircularOrbitsInAFormulaAgreesWithTheBuiltInHole) {
    std::vector<std::pair<std::string, std::string>> pairs{
        {schwarzschild, "[space]\nhamiltonian = \"schwarzschild\"\nrg = 1\n"}};
    if (is_available("kerr")) pairs.emplace_back(kerr, "[space]\nhamiltonian = \"kerr\"\nmass = 0.5\nspin = 0.8\n");
    for (const auto& [formula_space, built_in_space] : pairs)
        for (const std::string normal : {"[0,0,2]", "[0,0,-1]"}) {
            const Override axis = "object.disk.normal=" + normal;
            const auto formula = plan_of_text(formula_space + camera + disk, {axis}),
                       built_in = plan_of_text(built_in_space + camera + disk, {axis});
            int compared = 0;
            for (int i = 0; i < 200; ++i) {
                const double radius = 1.6 + 13.4 * i / 199, angle = 0.7 * i;
                RayEnd end{};
                end.status = Status::hit;
                end.q[0] = radius * std::cos(angle);
                end.q[1] = radius * std::sin(angle);
                const RayStart start = built_in->scene->space.start(end.q, {0.3, std::sin(2.1 * i), 0.7});
                std::copy_n(start.p, 3, end.p);
                end.pt = start.pt;
                const CameraRay ray{start, 1};
                const double expected = redshift_of(*built_in, {&end, &ray});
                if (!(expected > 0)) continue;  // no orbit is slower than light here
                ++compared;
                EXPECT_NEAR(redshift_of(*formula, {&end, &ray}) / expected, 1, 1e-6) << normal << ' ' << radius;
            }
            EXPECT_GT(compared, 150);
        }
}

// In Boyer–Lindquist coordinates, the angular velocity is √M/(r^(3/2) ± a √M) (Bardeen, Press and Teukolsky 1972).
TEST(DiskVelocity, OfCircularOrbitsInBoyerLindquistCoordinatesIsTheClosedForm) {
    std::string text = scene_text("kerr-boyer-lindquist.toml");
    text.replace(text.find("velocity = [0, 0, 0]"), 20, "");
    for (const double side : {1.0, -1.0}) {
        const auto plan =
            plan_of_text(text, {"sky.checker=true", "object.equator.normal=[0,0," + std::to_string(side) + "]"});
        for (const double r : {4.0, 6.5, 13.9}) {
            const Double3 v = plan->scene->sources.orbits[0].velocity({0, r, 0});
            EXPECT_NEAR(v[0] / (-side * r / (std::pow(r, 1.5) + side * 0.95)), 1, 1e-8) << r;
            EXPECT_NEAR(v[1], 0, 1e-15);
        }
    }
}

bool has_remark(const Plan& plan, const std::string& part) {
    return std::any_of(plan.remarks.begin(), plan.remarks.end(),
                       [&](const std::string& remark) { return remark.find(part) != std::string::npos; });
}

TEST(DiskVelocity, IsZeroWhereThereAreNoCircularOrbits) {
    const std::string text = schwarzschild + camera + disk;
    const auto plan = plan_of_text(text, {"object.disk.inner=1.1"});
    EXPECT_TRUE(has_remark(*plan, "object.disk: the matter of the disk is at rest at distances between 1.1 and 1.5 "
                                  "from its centre"));
    EXPECT_TRUE(plan_of_text(text, {})->remarks.empty());
    RayEnd end{};
    end.status = Status::hit;
    end.q[0] = 1.25;
    end.pt = 1;
    const CameraRay ray{{}, 1};
    EXPECT_NEAR(redshift_of(*plan, {&end, &ray}), std::sqrt(1 - 1 / 1.25), 1e-12);
    for (const auto& [key, reason] : {std::pair{"object.disk.center=[1,0,0]", "axis of the disk"},
                                      {"object.disk.normal=[0,1,1]", ""}, {"object.disk.center=[0,0,1]", "plane"}}) {
        const auto other = plan_of_text(text, {key});
        EXPECT_EQ(has_remark(*other, "the matter of the disk is at rest, because"), *reason != 0) << key;
        EXPECT_TRUE(has_remark(*other, reason) || !*reason) << key;
    }
    const auto turned = plan_of_text(kerr + camera + disk, {"object.disk.normal=[0,1,1]"});
    EXPECT_TRUE(has_remark(*turned, "the space is not symmetric about the axis of the disk"));
}

// Matter with the angular velocity Ω emits p · u = u^t (p_t + Ω L) with u^t = 1/√(1 − r_g/r − Ω² r²).
TEST(DiskVelocity, IsTakenFromTheScene) {
    const std::string built_in = "[space]\nhamiltonian = \"schwarzschild\"\nrg = 1\n";
    for (const std::string& space : {schwarzschild, built_in}) {
        const auto plan = plan_of_text(space + camera + disk, {"object.disk.velocity=[\"-0.05*y\",\"0.05*x\",0]"});
        RayEnd end{};
        end.status = Status::hit;
        const double r = 4, omega = 0.05, angular_momentum = -r;
        end.q[0] = r;
        end.p[1] = -1;
        end.pt = 1;
        const CameraRay ray{{}, 1};
        EXPECT_NEAR(redshift_of(*plan, {&end, &ray}),
                    std::sqrt(1 - 1 / r - omega * omega * r * r) / (1 + omega * angular_momentum), 1e-12);
    }
    const auto fast = plan_of_text(schwarzschild + camera + disk, {"object.disk.velocity=[\"-0.1*y\",\"0.1*x\",0]"});
    EXPECT_TRUE(has_remark(*fast, "object.disk: its velocity is not slower than light at distances from"));
}

}  // namespace
}  // namespace kagero::test
