// Tests of media, and of surfaces that send light on: loading, overrides, printing, messages, and units.
#include "plan/plan.h"
#include "plan/units.h"
#include "scene/load/load.h"
#include "scene/print.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace kagero::test {
namespace {

/// A scene with two media, of which one is a formula, and with a surface of each material.
const char* const scene_with_media = R"([space]
hamiltonian = "flat"
[[medium]]
name = "glass"
hamiltonian = "uniform"
n0 = 1.6
center = [1, 0, 0]
[medium.integrator]
step = 0.25
)"
                                     R"([[medium]]
name = "core"
hamiltonian = "formula"
H = "0.5*(px^2 + py^2 + pz^2) - 0.5*n^2"
domain = "9 - r"
[medium.constants]
a = 0.5
[medium.let]
n = "a*exp(-r^2) + 1"
)"
                                     R"([camera]
position = [0, -5, 0]
look_at = [0, 0, 0]
up = [0, 0, 1]
medium = "space"
[film]
size = [4, 4]
max_bounces = 20
)"
                                     R"([[object]]
name = "ball"
shape = "sphere"
center = [0, 0, 0]
radius = 2
material = "boundary"
interior = "glass"
fresnel = "transmit"
tint = [1, 0.5, 0]
)"
                                     R"([[object]]
name = "kernel"
shape = "box"
min = [-1, -1, -1]
max = [1, 1, 1]
material = "boundary"
interior = "core"
exterior = "glass"
)"
                                     R"([[object]]
name = "wall"
shape = "rectangle"
origin = [-9, 9, -9]
edge_u = [18, 0, 0]
edge_v = [0, 0, 18]
material = "mirror"
[[object]]
name = "plate"
shape = "rectangle"
origin = [-9, -9, -9]
edge_u = [18, 0, 0]
edge_v = [0, 18, 0]
color = [1, 0, 0]
)";

SceneDescription load(const std::string& text, const std::vector<Override>& overrides = {}) {
    return load_scene_text(text, "scene.toml", overrides, catalogue("auto"));
}

/// Returns `scene_with_media` with a text replaced.
std::string with(const std::string& find, const std::string& replacement) {
    std::string text = scene_with_media;
    const std::size_t at = text.find(find);
    EXPECT_NE(at, std::string::npos) << find;
    return at == std::string::npos ? text : text.replace(at, find.size(), replacement);
}

/// Returns the message of the InputError for a scene, or "" if the scene is accepted.
std::string refusal(const std::string& text, const std::vector<Override>& overrides = {}) {
    try {
        load(text, overrides);
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

TEST(Media, AreLoadedWithTheKeysOfSpaces) {
    const SceneDescription scene = load(scene_with_media);
    ASSERT_EQ(scene.media.size(), 2u);
    const MediumDescription &glass = scene.media[0], &core = scene.media[1];
    EXPECT_EQ(glass.name, "glass");
    EXPECT_EQ(glass.space.hamiltonian, "uniform");
    EXPECT_EQ(glass.space.parameters[0].second, 1.6);
    EXPECT_EQ(glass.space.center, (Double3{1, 0, 0}));
    EXPECT_EQ(glass.integrator.step, 0.25);
    EXPECT_EQ(glass.integrator.escape_radius, 51);  // encloses the sphere of radius 50 around the origin
    EXPECT_EQ(glass.location.line, 3);
    ASSERT_TRUE(core.space.formula);
    EXPECT_EQ(core.space.formula->constants[0].second, 0.5);
    EXPECT_GE(core.space.formula->parsed.domain, 0);
    EXPECT_EQ(name_of_medium(scene, 0), "space");
    EXPECT_EQ(name_of_medium(scene, 2), "core");

    const ObjectDescription &ball = scene.objects[0], &kernel = scene.objects[1];
    EXPECT_EQ(ball.material, Material::boundary);
    EXPECT_EQ(ball.interior, 1u);
    EXPECT_EQ(ball.exterior, 0u);
    EXPECT_EQ(ball.fresnel, Fresnel::transmit);
    EXPECT_EQ(ball.tint, (Double3{1, 0.5, 0}));
    EXPECT_EQ(ball.interior_location.line, 33);
    EXPECT_EQ(ball.exterior_location.line, ball.location.line);
    EXPECT_EQ(kernel.interior, 2u);
    EXPECT_EQ(kernel.exterior, 1u);
    EXPECT_EQ(kernel.fresnel, Fresnel::automatic);
    EXPECT_EQ(scene.objects[2].material, Material::mirror);
    EXPECT_EQ(scene.objects[3].material, Material::surface);
    EXPECT_EQ(scene.film.max_bounces, 20u);
    EXPECT_EQ(scene.camera.medium_index, 0u);
    EXPECT_FALSE(load(with("medium = \"space\"\n", "")).camera.medium_index);
    EXPECT_EQ(load(with("medium = \"space\"\n", "medium = \"core\"\n")).camera.medium_index, 2u);
    EXPECT_EQ(load(with("max_bounces = 20\n", "")).film.max_bounces, 8u);
}

TEST(Media, AreReachedByOverrides) {
    const SceneDescription scene =
        load(scene_with_media, {"medium.glass.n0=1.33", "medium.glass.integrator.step=0.5", "medium.core.constants.a=2",
                                "object.ball.interior=core", "object.ball.tint=[0,0,0]", "film.max_bounces=0"});
    EXPECT_EQ(scene.media[0].space.parameters[0].second, 1.33);
    EXPECT_EQ(scene.media[0].integrator.step, 0.5);
    EXPECT_EQ(scene.media[1].space.formula->constants[0].second, 2);
    EXPECT_EQ(scene.objects[0].interior, 2u);
    EXPECT_EQ(scene.objects[0].tint, (Double3{0, 0, 0}));
    EXPECT_EQ(scene.film.max_bounces, 0u);
    const std::pair<const char*, const char*> refused[] = {
        {"medium.glas.n0=1", "there is no medium \"glas\"; did you mean \"glass\"? The media are: glass core"},
        {"medium.glass=1", "the form medium.NAME.key=value"},
        {"medium.glass.n1=1", "unknown key medium.glass.n1; did you mean \"n0\"?"},
        {"medium.glass.n0=-1", "medium.glass.n0 = -1 is out of range: the legal range is 0 < value"},
        {"medium.glass.integrator.stepp=1", "unknown key medium.glass.integrator.stepp; did you mean \"step\"?"},
        {"medium.core.constants.b=x", "medium.core.constants.b = \"x\" is not legal: it must be a number"},
        {"medium.core.let.n=1+q", "medium.core.let.n, position 3: unknown name q"},
    };
    for (const auto& [override_text, fragment] : refused)
        EXPECT_NE(refusal(scene_with_media, {override_text}).find(fragment), std::string::npos)
            << refusal(scene_with_media, {override_text});
    EXPECT_NE(refusal("[space]\nhamiltonian = \"flat\"", {"medium.a.n0=1"}).find("the scene has no media"),
              std::string::npos);
}

TEST(Media, ArePrintedSoThatTheyLoadAsTheSameScene) {
    for (const std::vector<Override>& overrides :
         {std::vector<Override>{},
          {"medium.core.integrator.method=dp85", "medium.core.integrator.rescale=1/n"},
          {"integrator.escape_radius=1e12", "film.max_bounces=8"}}) {
        const SceneDescription scene = load(scene_with_media, overrides);
        const std::string printed = print_scene(scene);
        const SceneDescription reloaded = load(printed);
        EXPECT_EQ(print_scene(reloaded), printed);
        ASSERT_EQ(reloaded.media.size(), 2u);
        for (std::size_t i = 0; i < 2; ++i) {
            EXPECT_EQ(reloaded.media[i].space.parameters, scene.media[i].space.parameters);
            EXPECT_EQ(reloaded.media[i].space.center, scene.media[i].space.center);
            EXPECT_EQ(reloaded.media[i].integrator.step, scene.media[i].integrator.step);
            EXPECT_EQ(reloaded.media[i].integrator.escape_radius, scene.media[i].integrator.escape_radius);
            EXPECT_EQ(reloaded.media[i].integrator.rescale, scene.media[i].integrator.rescale);
        }
        EXPECT_EQ(reloaded.media[1].space.formula->helpers, scene.media[1].space.formula->helpers);
        for (std::size_t i = 0; i < scene.objects.size(); ++i) {
            EXPECT_EQ(reloaded.objects[i].material, scene.objects[i].material);
            EXPECT_EQ(reloaded.objects[i].interior, scene.objects[i].interior);
            EXPECT_EQ(reloaded.objects[i].exterior, scene.objects[i].exterior);
            EXPECT_EQ(reloaded.objects[i].fresnel, scene.objects[i].fresnel);
            EXPECT_EQ(reloaded.objects[i].tint, scene.objects[i].tint);
        }
        EXPECT_EQ(reloaded.film.max_bounces, scene.film.max_bounces);
        EXPECT_EQ(reloaded.camera.medium, "space");
    }
    // The new keys do not appear in scenes without media and materials.
    const std::string plain = print_scene(load(
        "[space]\nhamiltonian = \"flat\"\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\n[film]\nsize = [4, 4]\n"
        "[[object]]\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 0.5\n"));
    for (const char* key : {"medium", "material", "tint", "max_bounces", "fresnel"})
        EXPECT_EQ(plain.find(key), std::string::npos) << plain;
}

TEST(Media, AreRefusedWithPositionAndRemedy) {
    const std::string tint = "tint = [1, 0.5, 0]";
    struct {
        std::string find, replacement;
        const char* position;
        const char* fragment;
    } const cases[] = {
        // media
        {"name = \"glass\"\n", "", "3:1", "the required key medium.name is missing"},
        {"name = \"glass\"", "name = 2", "4:8", "medium.name = 2 is not legal: it must be a string"},
        {"name = \"glass\"", "name = \"\"", "4:8", "a name that is not empty"},
        {"name = \"glass\"", "name = \"space\"", "4:8", "\"space\" names the table [space]"},
        {"name = \"glass\"", "name = \"auto\"", "4:8", "\"auto\" is a value of camera.medium"},
        {"name = \"core\"", "name = \"glass\"", "11:8", "two media are named \"glass\"; the other one is in line 3"},
        {"\"uniform\"", "\"unifrm\"", "5:15",
         "medium.glass.hamiltonian = \"unifrm\" is not a legal value; did you mean \"uniform\"?"},
        {"n0 = 1.6", "n00 = 1.6", "6:1", "unknown key medium.glass.n00; did you mean \"n0\"?"},
        {"n0 = 1.6", "n0 = 0", "6:6", "medium.glass.n0 = 0 is out of range: the legal range is 0 < value"},
        {"n0 = 1.6", "sky_frame = [0, 0, 0]", "6:1",
         "medium.glass.sky_frame is not legal: only rays that leave [space]"},
        {"domain = \"9 - r\"", "far_domain = \"9 - r\"", "14:1", "medium.core.far_domain is not legal"},
        {"H = \"0.5", "H = \"0.5.", "13:5", "medium.core.H, position"},
        {"step = 0.25", "step = -1", "9:8", "medium.glass.integrator.step = -1 is out of range"},
        {"step = 0.25", "method = \"dp58\"", "9:10", "medium.glass.integrator.method = \"dp58\" is not a legal value"},
        {"step = 0.25", "lanes = \"many\"", "9:9", "medium.glass.integrator.lanes = \"many\""},
        // references to media
        {"interior = \"glass\"", "interior = \"glas\"", "33:12",
         "object.ball.interior = \"glas\" is not a legal value; did you mean \"glass\"? Legal names: "
         "space, glass, core"},
        {"exterior = \"glass\"", "exterior = \"gloss\"", "43:12", "did you mean \"glass\"?"},
        {"medium = \"space\"", "medium = \"spce\"", "23:10",
         "camera.medium = \"spce\" is not a legal value; did you mean \"space\"? Legal names: "
         "space, glass, core, auto"},
        {"exterior = \"glass\"", "exterior = \"core\"", "42:12",
         "object.kernel.interior = \"core\" is the same medium as object.kernel.exterior; a boundary separates"},
        {"interior = \"glass\"", "interior = \"space\"", "33:12",
         "is the same medium as object.ball.exterior, whose default is \"space\""},
        // materials
        {"material = \"mirror\"", "material = \"mirrror\"", "50:12",
         "did you mean \"mirror\"? Legal names: surface, mirror, boundary"},
        {"material = \"mirror\"", "material = \"difuse\"", "50:12", "Legal names: surface, mirror, boundary, diffuse"},
        {"material = \"mirror\"", "emission_strength = 1", "50:1",
         "object.wall.emission_strength is legal only with material = \"diffuse\""},
        {"interior = \"glass\"\n", "", "32:12", "the required key object.ball.interior is missing: a boundary needs"},
        {"fresnel = \"transmit\"", "fresnel = \"transmits\"", "34:11",
         "did you mean \"transmit\"? Legal names: auto, transmit, none"},
        {"tint = [1, 0.5, 0]", "tint = [1, 1.5, 0]", "35:12",
         "object.ball.tint[1] = 1.5 is out of range: the legal range is 0 <= value <= 1"},
        {"tint = [1, 0.5, 0]", "tint = [1, 0.5, -0.1]", "35:17", "the legal range is 0 <= value <= 1"},
        {"material = \"mirror\"", "material = \"boundary\"\ninterior = \"glass\"", "50:12",
         "because a rectangle has no interior; a boundary is a box, room, sphere or closed mesh"},
        {"material = \"mirror\"", "material = \"mirror\"\ninterior = \"glass\"", "51:1",
         "object.wall.interior is legal only with material = \"boundary\""},
        {"material = \"mirror\"", "fresnel = \"none\"", "50:1",
         "object.wall.fresnel is legal only with material = \"boundary\""},
        {"color = [1, 0, 0]", "tint = [1, 0, 0]", "57:1",
         "object.plate.tint is legal only with material = \"mirror\" or \"boundary\""},
        {"material = \"mirror\"", "material = \"mirror\"\ncolor = [1, 0, 0]", "51:1",
         "object.wall.color is not legal with material = \"mirror\", which sends light on and emits none; to color "
         "this light, state tint = [r, g, b] instead"},
        {tint, tint + "\nchecker = [2, 2]", "36:1", "object.ball.checker is not legal with material = \"boundary\""},
        {"exterior = \"glass\"", "exterior = \"glass\"\nfaces = { px = [1, 0, 0] }", "44:1", "object.kernel.faces"},
        {"material = \"mirror\"", "material = \"mirror\"\nshading = \"lambert\"", "51:11",
         "object.wall.shading = \"lambert\" is not legal with material = \"mirror\""},
        {"max_bounces = 20", "max_bounces = 1001", "26:15", "the legal range is 0 <= value <= 1000"},
        // cameras
        {"medium = \"space\"", "observer = \"falling\"", "23:12",
         "camera.observer = \"falling\" is not legal together with the medium \"glass\" (line 3), whose Hamiltonian "
         "\"uniform\" is not a spacetime"},
    };
    for (const auto& [find, replacement, position, fragment] : cases) {
        const std::string message = refusal(with(find, replacement));
        EXPECT_NE(message.find("scene.toml:" + std::string(position) + ": "), std::string::npos) << replacement << "\n"
                                                                                                 << message;
        EXPECT_NE(message.find(fragment), std::string::npos) << replacement << "\n" << message;
    }
}

TEST(Media, OfSpacetimesMayBeSeenByAFallingCamera) {
    const std::vector<Override> falling{"camera.observer=falling", "space.hamiltonian=schwarzschild"};
    std::string text = with("\"uniform\"\nn0 = 1.6", "\"schwarzschild\"");
    EXPECT_NE(refusal(text, falling).find("the medium \"core\""), std::string::npos) << refusal(text, falling);
    std::vector<Override> with_pt = falling;
    with_pt.emplace_back("medium.core.constants.pt=1");
    EXPECT_EQ(refusal(text, with_pt), "");
    // A medium that no object uses has no effect.
    std::vector<Override> unused = falling;
    unused.emplace_back("object.kernel.interior=space");
    EXPECT_EQ(refusal(text, unused), "");
}

TEST(Media, WithoutUseGetARemark) {
    const auto has_remark = [](const std::vector<Override>& overrides, const std::string& part) {
        const Plan plan = make_plan(load(scene_with_media, overrides), Options{});
        return std::any_of(plan.remarks.begin(), plan.remarks.end(),
                           [&](const std::string& remark) { return remark.find(part) != std::string::npos; });
    };
    EXPECT_FALSE(has_remark({}, "has no effect"));
    EXPECT_TRUE(has_remark({"object.kernel.interior=space"}, "medium.core has no effect: no object states it as its "));
    EXPECT_TRUE(has_remark({"medium.core.constants.b=1"}, "medium.core.constants.b has no effect"));
}

// A scene whose lengths are all multiplied by a power of two has the same lengths in the unit of the kernels.
TEST(Media, HaveTheirLengthsInTheUnitOfTheKernels) {
    const auto description = [](double unit) {
        const auto length = [&](double value) { return std::to_string(value * unit); };
        return load("[space]\nhamiltonian = \"flat\"\n[integrator]\nescape_radius = " + length(64) +
                    "\n[[medium]]\nname = \"m\"\nhamiltonian = \"fisheye\"\nn0 = 3\nradius = " + length(2) +
                    "\ncenter = [" + length(1) + ", 0, 0]\n[medium.integrator]\nescape_radius = " + length(32) +
                    "\n[camera]\nposition = [0, 0, " + length(9) + "]\nlook_at = [0, 0, 0]\n[film]\nsize = [4, 4]\n");
    };
    const double factor = 1 << 30;
    SceneDescription small = description(1), large = description(factor);
    const Module& module = *make_scene(small, Options{}, Purpose::picture)->space.module;
    EXPECT_EQ(length_unit(small), 1);
    const double unit = length_unit(large);
    EXPECT_GT(unit, 1);
    convert_lengths(large, module, unit);
    const MediumDescription &medium = large.media[0], &expected = small.media[0];
    EXPECT_EQ(medium.space.parameters[0].second, 3);
    EXPECT_EQ(medium.space.parameters[1].second * unit, expected.space.parameters[1].second * factor);
    EXPECT_EQ(medium.space.center[0] * unit, expected.space.center[0] * factor);
    EXPECT_EQ(medium.integrator.escape_radius * unit, expected.integrator.escape_radius * factor);
    EXPECT_EQ(medium.space.center[0] / large.camera.position[2], 1.0 / 9);
    // Formulas keep the unit of the scene.
    EXPECT_EQ(length_unit(load(scene_with_media, {"integrator.escape_radius=1e9"})), 1);
}

}  // namespace
}  // namespace kagero::test
