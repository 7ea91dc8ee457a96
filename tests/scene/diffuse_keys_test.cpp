// Tests of the keys of diffuse surfaces: what is loaded, printed and refused.
#include "tests/support/scene_fixture.h"

namespace kagero::test {
namespace {

std::string with_ball(const std::string& keys) {
    return std::string(good_scene) +
           "[[object]]\nname = \"lamp\"\nshape = \"sphere\"\ncenter = [1, 1, 0]\nradius = 0.25\n" + keys;
}

TEST_F(SceneTest, LoadsDiffuseSurfaces) {
    const SceneDescription scene =
        load(with_ball("material = \"diffuse\"\ncolor = [0.5, 1, 0]\nemission_strength = 12.5\n"));
    EXPECT_EQ(scene.objects.back().material, Material::diffuse);
    EXPECT_EQ(scene.objects.back().emission_strength, 12.5);
    const SceneDescription again = load(print_scene(scene));
    EXPECT_EQ(print_scene(again), print_scene(scene));
    EXPECT_EQ(again.objects.back().emission_strength, 12.5);
    EXPECT_EQ(load(with_ball("material = \"diffuse\"\n")).objects.back().emission_strength, 0);
}

TEST_F(SceneTest, RefusesKeysThatDoNotSuitDiffuseSurfaces) {
    struct Case {
        std::string keys, message;
    };
    for (const Case& wrong :
         std::vector<Case>{{"material = \"diffuse\"\ncolor = [1.5, 0, 0]\n", "albedo"},
                           {"material = \"diffuse\"\ncolor = [1.5, 0, 0]\nchecker = [2, 2]\n", "0 <= value <= 1"},
                           {"material = \"diffuse\"\nemission_strength = -1\n", "object.lamp.emission_strength"},
                           {"material = \"diffuse\"\nshading = \"lambert\"\n", "lambert"},
                           {"material = \"diffuse\"\ntint = [1, 1, 1]\n", "object.lamp.tint is legal only with"},
                           {"material = \"diffuse\"\nfresnel = \"none\"\n", "object.lamp.fresnel is legal only with"},
                           {"material = \"mirror\"\nemission_strength = 1\n",
                            "emission_strength is legal only with material = \"diffuse\""},
                           {"emission_strength = 1\n", "emission_strength is legal only with material = \"diffuse\""},
                           {"material = \"difuse\"\n", "did you mean \"diffuse\""}}) {
        const std::string refused = refusal(with_ball(wrong.keys));
        EXPECT_NE(refused.find(wrong.message), std::string::npos) << wrong.keys << refused;
        EXPECT_NE(refused.find("scene.toml:"), std::string::npos);
    }
    const std::string faces = std::string(good_scene) +
                              "[[object]]\nname = \"box\"\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n"
                              "material = \"diffuse\"\n[object.faces]\npx = [2, 0, 0]\n";
    EXPECT_NE(refusal(faces).find("albedo"), std::string::npos);
}

}  // namespace
}  // namespace kagero::test
