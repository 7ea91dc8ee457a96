// Tests of loading scenes, messages for malformed scenes, and printing scenes.
#include "tests/support/scene_fixture.h"

namespace kagero::test {
namespace {

/// An edit of `good_scene`, and the expected message.
struct Malformed {
    const char* find;
    const char* replace;
    const char* position;  ///< Position of the error, as "line:column".
    const char* fragment;  ///< Part of the message.
};

const char* const sphere = "\"sphere\"\ncenter = [1, 0, 0]\nradius = 0.25";

const Malformed malformed[] = {
    // spelling
    {"rg = 0.08", "rgg = 0.08", "3:1",
     "unknown key space.rgg; did you mean \"rg\"? Legal names: hamiltonian, center, rg"},
    {"[film]", "[flim]", "11:2", "unknown key flim; did you mean \"film\"?"},
    {"fov = 60", "fow = 60", "10:1", "did you mean \"fov\"?"},
    {"radius = 0.25", "radius = 0.25\nedge_u = [1, 0, 0]", "20:1", "unknown key object.ball.edge_u"},
    {"\"schwarzschild\"", "\"schwarzshild\"", "2:15",
     "did you mean \"schwarzschild\"? Legal names: flat, schwarzschild"},
    {"\"schwarzschild\"", "\"formula\"", "2:15", "legal names: flat, schwarzschild"},
    {"\"schwarzschild\"", "\"flat\"", "3:1", "unknown key space.rg; legal names: hamiltonian, center"},
    {"step = 0.05", "method = \"gaus8\"", "5:10", "did you mean \"gauss8\"? Legal names: verlet, gauss8, yoshida4"},
    {"step = 0.05", "hit = \"hermit\"", "5:7", "did you mean \"hermite\"?"},
    {"\"sphere\"", "\"spere\"", "17:9", "did you mean \"sphere\"?"},
    {"px = [1, 0, 0]", "xp = [1, 0, 0]", "33:1", "unknown key object.hall.faces.xp"},
    {"size = [64, 48]", "size = [64, 48]\nlayers = [\"colour\"]", "13:11",
     "did you mean \"color\"? Legal names: color, status, steps"},
    {"hamiltonian = \"schwarzschild\"", "hamiltonan = \"schwarzschild\"", "2:1",
     "unknown key space.hamiltonan; did you mean \"hamiltonian\"?"},
    {"shape = \"sphere\"", "shpe = \"sphere\"", "17:1", "unknown key object.ball.shpe; did you mean \"shape\"?"},
    // missing
    {"hamiltonian = \"schwarzschild\"", "", "1:1", "space.hamiltonian is missing"},
    {"position = [0, -3, 0]", "", "6:1", "camera.position is missing"},
    {"look_at = [0, 0, 0]", "", "6:1", "camera.look_at is missing"},
    {"size = [64, 48]", "", "11:1", "film.size is missing"},
    {"[film]\nsize = [64, 48]\n", "", "1:1", "film.size is missing"},
    {"radius = 0.25", "", "15:1", "object.ball.radius is missing"},
    // types
    {"rg = 0.08", "rg = \"big\"", "3:6", "space.rg = \"big\" is not legal: it must be a number"},
    {"rg = 0.08", "rg = 2003-01-01", "3:6", "space.rg = a date is not legal: it must be a number"},
    {"[64, 48]", "[64.0, 48]", "12:9", "film.size[0] = 64 is not legal: it must be a whole number"},
    {"[64, 48]", "[64, 48, 3]", "12:8", "film.size = [64, 48, 3] is not legal: it must be an array [width, height]"},
    {"position = [0, -3, 0]", "position = [0, -3]", "7:12", "it must be an array of 3 numbers"},
    {"position = [0, -3, 0]", "position = [0, true, 0]", "7:16",
     "camera.position[1] = true is not legal: it must be a number"},
    {"[[object]]\nname = \"ball\"", "[object]\nname = \"ball\"", "20:1", "cannot redefine"},
    {"color = [0, 0, 0.1]", "checker = [2, 2]", "14:11", "sky.checker = [2, 2] is not legal: it must be true or false"},
    {"px = [1, 0, 0]", "px = 1", "33:6", "object.hall.faces.px = 1 is not legal: it must be a colour [r, g, b]"},
    // ranges
    {"rg = 0.08", "rg = -1", "3:6", "space.rg = -1 is out of range: the legal range is 0 <= value <= 1000"},
    {"rg = 0.08", "rg = nan", "3:6", "space.rg = nan is not legal: it must be a finite number"},
    {"rg = 0.08", "rg = inf", "3:6", "space.rg = inf is not legal: it must be a finite number"},
    {"step = 0.05", "step = 0", "5:8", "integrator.step = 0 is out of range: the legal range is 0 < value"},
    {"step = 0.05", "max_steps = 0", "5:13", "legal range is 1 <= value"},
    {"step = 0.05", "escape_radius = -2", "5:17", "legal range is 0 < value"},
    {"step = 0.05", "solver_tolerance = 1", "5:20", "legal range is 0 <= value < 1"},
    {"fov = 60", "fov = 180", "10:7", "camera.fov = 180 is out of range: the legal range is 0 < value < 180"},
    {"[64, 48]", "[0, 48]", "12:9", "film.size[0] = 0 is out of range: the legal range is 1 <= value <= 65536"},
    {"[64, 48]", "[64, 65537]", "12:13", "legal range is 1 <= value <= 65536"},
    {"[0, 0, 0.1]", "[0, -0.1, 0]", "14:13", "sky.color[1] = -0.1 is out of range: the legal range is 0 <= value"},
    {"radius = 0.25", "radius = 0", "19:10", "legal range is 0 < value"},
    {"checker = [4, 4]", "checker = [0, 4]", "26:12",
     "object.floor.checker[0] = 0 is out of range: the legal range is 0 < value"},
    // geometry
    {"look_at = [0, 0, 0]", "look_at = [0, -3, 0]", "8:11", "it must be a point other than camera.position"},
    {"up = [0, 0, 1]", "up = [0, 2, 0]", "9:6", "camera.up = [0, 2, 0] is parallel to the viewing direction"},
    {"up = [0, 0, 1]", "up = [0, 0, 0]", "9:6", "it must be a vector that is not zero"},
    {"up = [0, 0, 1]", "", "8:11", "camera.up = [0, 1, 0] (the default) is parallel to the viewing direction"},
    {"edge_u = [2, 0, 0]", "edge_u = [0, 0, 0]", "24:10", "it must be a vector that is not zero"},
    {"edge_v = [0, 2, 0]", "edge_v = [-1, 0, 0]", "25:10", "not parallel to edge_u"},
    {"max = [4, 4, 4]", "max = [4, -4, 4]", "31:7", "it must be greater than min in every coordinate, but min[1] = -4"},
    {"[0, 0, 0.1]", "[0, 0, 0.1]\npole = [0, 0, 0]", "15:8", "sky.pole"},
    // names and paints
    {"name = \"floor\"", "name = \"ball\"", "21:8", "two objects are named \"ball\"; the other one is in line 15"},
    {"name = \"floor\"", "name = \"\"", "21:8", "it must be a name that is not empty"},
    {"checker = [4, 4]", "color = [1, 1, 1]\ntexture = \"x.png\"", "27:1", "texture and color exclude each other"},
    {"checker = [4, 4]", "texture = \"no.png\"", "26:11", "there is no file "},
    {"shape = \"sphere\"", "shape = \"disk\"", "19:1", "unknown key object.ball.radius"},
    {sphere, "\"disk\"\ncenter = [1, 0, 0]\ninner = 2\nouter = 2", "20:9",
     "object.ball.outer = 2 is not legal: it must be greater than inner = 2"},
    {sphere, "\"disk\"\ncenter = [1, 0, 0]\nouter = 2", "15:1", "object.ball.inner is missing"},
    {sphere, "\"disk\"\ncenter = [1, 0, 0]\ninner = 1\nouter = 2\ncolor = [1, 1, 1]\ntemperature = 6000", "22:1",
     "object.ball.temperature and color exclude each other"},
    {sphere, "\"disk\"\ncenter = [1, 0, 0]\ninner = 1\nouter = 2\ntemperature = 20", "21:15",
     "legal range is 500 <= value <= 1000000000"},
    {sphere, "\"disk\"\ncenter = [1, 0, 0]\ninner = 1\nouter = 2\nnormal = [0, 0, 0]", "21:10",
     "it must be a vector that is not zero"},
    {"shape = \"sphere\"\ncenter = [1, 0, 0]\nradius = 0.25", "shape = \"mesh\"\nfile = \"a.stl\"", "18:8",
     "it must be a .obj, .ply, .gltf or .glb file"},
    // further keys of integrator, camera and film
    {"step = 0.05", "tolerance = 1.5", "5:13", "integrator.tolerance"},
    {"step = 0.05", "refill = \"maybe\"", "5:10", "auto"},
    {"step = 0.05", "lanes = 0", "5:9", "integrator.lanes = 0 is out of range: the legal range is 1 <= value <= 1024"},
    {"step = 0.05", "lanes = \"many\"", "5:9", "legal names: auto"},
    {"step = 0.05", "max_pixel_error = 0", "5:19", "legal range is 0 < value"},
    {"step = 0.05", "rescale = \"r^^2\"", "5:11", "integrator.rescale, position 3: "},
    {"fov = 60", "type = \"ortographic\"", "10:8",
     "did you mean \"orthographic\"? Legal names: perspective, equirectangular"},
    {"fov = 60", "height = 2", "10:1", "unknown key camera.height"},
    {"fov = 60", "type = \"orthographic\"\nheight = 0", "11:10",
     "camera.height = 0 is out of range: the legal range is 0 < value"},
    {"fov = 60", "observer = \"zammo\"", "10:12",
     "did you mean \"zamo\"? Legal names: static, zamo, falling, coordinate"},
    {"[64, 48]", "[64, 48]\nspp = 0", "13:7", "film.spp = 0 is out of range: the legal range is 1 <= value <= 65536"},
    {"[64, 48]", "[64, 48]\nseed = -1", "13:8",
     "film.seed = -1 is out of range: the legal range is 0 <= value <= 4294967295"},
    // the far sky
    {"[0, 0, 0.1]", "[0, 0, 0.1]\nfar = { color = [1, 0, 0] }", "15:7", "the space \"schwarzschild\" has only one sky"},
    {"[0, 0, 0.1]", "[0, 0, 0.1]\nfar = true", "15:7", "sky.far = true is not legal: it must be a table: [sky.far]"},
    // not TOML
    {"rg = 0.08", "rg = ", "3:6", ""},
    {"rg = 0.08", "rg = 0.08\nrg = 0.1", "4:6", "cannot redefine"},
};

/// Returns `good_scene` with a text replaced.
std::string edited(const char* find, const char* replace) {
    std::string text = good_scene;
    const auto at = text.find(find);
    EXPECT_NE(at, std::string::npos) << find;
    return text.replace(at, std::string(find).size(), replace);
}

}  // namespace

using LoadScene = SceneTest;

TEST_F(LoadScene, RefusesMalformedScenesWithPositionAndReason) {
    for (const Malformed& entry : malformed) {
        const std::string message = refusal(edited(entry.find, entry.replace));
        EXPECT_NE(message.find("scene.toml:" + std::string(entry.position) + ": "), std::string::npos)
            << entry.replace << "\n"
            << message;
        EXPECT_NE(message.find(entry.fragment), std::string::npos) << entry.replace << "\n" << message;
    }
}

TEST_F(LoadScene, FillsInDefaults) {
    const SceneDescription scene = load(
        "space.hamiltonian = \"flat\"\nfilm.size = [1, 2]\n"
        "camera = { position = [0, 0, 1], look_at = [0, 0, 0] }\nobject = [{ shape = \"sphere\", "
        "center = [0, 0, 0], radius = 1 }]\n");
    EXPECT_EQ(scene.integrator.method, "verlet");
    EXPECT_EQ(scene.integrator.step, 0.5);
    EXPECT_EQ(scene.integrator.escape_radius, 50);
    EXPECT_EQ(scene.camera.up, (Double3{0, 1, 0}));
    EXPECT_EQ(scene.film.height, 2u);
    EXPECT_EQ(scene.sky.paint.color, (Double3{0, 0, 0}));
    ASSERT_EQ(scene.objects.size(), 1u);
    EXPECT_EQ(scene.objects[0].name, "object-1");
    EXPECT_EQ(scene.objects[0].paint.color, (Double3{0.8, 0.8, 0.8}));
    EXPECT_EQ(scene.objects[0].shading, Shading::emission);
}

TEST_F(LoadScene, AcceptsValuesThatDisableFeatures) {
    const char* keys =
        "cull = \"none\"\nrescale = \"none\"\nhit = \"chord\"\nrefill = \"auto\"\nsymmetry = \"auto\"\nlanes = "
        "\"auto\"";
    const SceneDescription scene = load(edited("step = 0.05", keys));
    EXPECT_FALSE(scene.integrator.cull);
    EXPECT_EQ(scene.integrator.rescale, "none");
    EXPECT_EQ(scene.integrator.hit, HitModel::chord);
    EXPECT_EQ(scene.integrator.method, "dp85");  // step control replaces the rescaling
    EXPECT_EQ(refusal(edited("[64, 48]", "[64, 48]\nspp = 1")), "");
}

TEST_F(LoadScene, ReadsParametersAndFaces) {
    const SceneDescription scene = load(good_scene);
    ASSERT_EQ(scene.space.parameters.size(), 1u);
    EXPECT_EQ(scene.space.parameters[0], (std::pair<std::string, double>{"rg", 0.08}));
    EXPECT_EQ(load(edited("rg = 0.08", "")).space.parameters[0].second, 0.1);
    const auto& faces = scene.objects[2].faces;
    EXPECT_EQ(faces[0].color, (Double3{1, 0, 0}));
    EXPECT_EQ(faces[1].color, (Double3{0.8, 0.8, 0.8}));
    EXPECT_EQ(faces[3].kind, Paint::Kind::checker);
    EXPECT_EQ(faces[3].checker, (std::array<double, 2>{2, 3}));
}

TEST_F(LoadScene, AppliesOverridesToEveryTable) {
    const SceneDescription scene =
        load(good_scene, {"space.rg=0.25", "integrator.method=verlet", "film.size=[8, 9]", "object.ball.radius=2",
                          "sky.checker = true", "object.hall.faces.nx.color=[0, 0, 1]", "object.floor.shading=lambert",
                          "space.center=[1,2,3]"});
    EXPECT_EQ(scene.space.parameters[0].second, 0.25);
    EXPECT_EQ(scene.integrator.method, "verlet");
    EXPECT_EQ(scene.film.width, 8u);
    EXPECT_EQ(scene.objects[0].radius, 2);
    EXPECT_EQ(scene.objects[1].shading, Shading::lambert);
    EXPECT_EQ(scene.objects[2].faces[1].color, (Double3{0, 0, 1}));
    EXPECT_EQ(scene.sky.paint.kind, Paint::Kind::checker);
    EXPECT_EQ(scene.space.center, (Double3{1, 2, 3}));
}

// `checker = false` does not exclude other paints.
TEST_F(LoadScene, KeepsTheTextureIfCheckerIsFalse) {
    std::ofstream(directory_ / "sky.png") << "only the name is used";
    const std::string textured = edited("color = [0, 0, 0.1]", "texture = \"sky.png\"");
    EXPECT_EQ(load(textured, {"sky.checker=false"}).sky.paint.kind, Paint::Kind::texture);
    EXPECT_EQ(load(textured, {"sky.checker=true"}).sky.paint.kind, Paint::Kind::checker);
}

TEST_F(LoadScene, RefusesMalformedOverrides) {
    const std::pair<const char*, const char*> cases[] = {
        {"space.rgg=1", "-D space.rgg=1: unknown key space.rgg; did you mean \"rg\"?"},
        {"space.rg=-1", "-D space.rg=-1: space.rg = -1 is out of range: the legal range is 0 <= value <= 1000"},
        {"space.rg=big", "-D space.rg=big: space.rg = \"big\" is not legal: it must be a number"},
        {"spcae.rg=1", "unknown key spcae; did you mean \"space\"?"},
        {"object.bal.radius=1", "there is no object \"bal\"; did you mean \"ball\"? The objects are: ball floor hall"},
        {"object.ball.radios=1", "unknown key object.ball.radios; did you mean \"radius\"?"},
        {"object.ball=1", "the form object.NAME.key=value"},
        {"film.size.x=1", "size = [64, 48] is not a table"},
        {"space.rg", "the form key.path=value"},
        {"=1", "the form key.path=value"},
        {"film.size=[1, 2", "-D film.size=[1, 2: "},
        {"space.rg=1\nx=2", "more than one value after '='"},
    };
    for (const auto& [override_text, fragment] : cases) {
        const std::string message = refusal(good_scene, {override_text});
        EXPECT_NE(message.find(fragment), std::string::npos) << override_text << "\n" << message;
    }
}

TEST_F(LoadScene, AcceptsASecondSkyForAWormhole) {
    const auto with_far = [](const char* keys) {
        return std::string("space = { hamiltonian = \"wormhole\" }\nfilm.size = [1, 2]\n"
                           "camera = { position = [0, 0, 1], look_at = [0, 0, 0] }\n") + keys;
    };
    EXPECT_EQ(load(with_far("[sky]\nchecker = true")).far_sky.paint.color, (Double3{0, 0, 0}));
    const SceneDescription scene =
        load(with_far("[sky.far]\ncolor = [1, 0.5, 0]\npole = [0, 1, 0]\n"), {"sky.checker=true"});
    EXPECT_EQ(scene.sky.paint.kind, Paint::Kind::checker);
    EXPECT_EQ(scene.far_sky.paint.color, (Double3{1, 0.5, 0}));
    EXPECT_EQ(scene.far_sky.pole, (Double3{0, 1, 0}));
    EXPECT_EQ(load(with_far(""), {"sky.far.checker=true"}).far_sky.paint.kind, Paint::Kind::checker);
    const std::string printed = print_scene(scene);
    EXPECT_NE(printed.find("[sky.far]\ncolor = [1, 0.5, 0]\npole = [0, 1, 0]\n"), std::string::npos) << printed;
    EXPECT_EQ(print_scene(load(printed)), printed);
    EXPECT_NE(
        refusal(with_far("[sky.far]\ncolour = [1, 0, 0]")).find("unknown key sky.far.colour; did you mean \"color\"?"),
        std::string::npos);
    EXPECT_NE(refusal(with_far("[sky.far]\nfar = {}")).find("unknown key sky.far.far"), std::string::npos);
    EXPECT_NE(refusal(with_far("[sky.far]\npole = [0, 0, 0]")).find("sky.far.pole"), std::string::npos);
}

TEST_F(LoadScene, ReadsDisksWithAColorOrATemperature) {
    const std::string head =
        "space.hamiltonian = \"flat\"\nfilm.size = [1, 2]\ncamera = { position = [0, 0, 1], look_at = [0, 0, 0] }\n"
        "[[object]]\nshape = \"disk\"\ncenter = [1, 2, 3]\ninner = 0.5\nouter = 4\n";
    const SceneDescription hot = load(head + "temperature = 7000\nnormal = [0, 1, 0]"), colored = load(head);
    EXPECT_EQ(hot.objects[0].temperature, 7000);
    EXPECT_EQ(hot.objects[0].normal, (Double3{0, 1, 0}));
    EXPECT_EQ(colored.objects[0].temperature, 0);
    EXPECT_EQ(colored.objects[0].normal, (Double3{0, 0, 1}));
    // An override of the colour replaces the temperature, and the reverse.
    EXPECT_EQ(load(head + "name = \"d\"\ntemperature = 7000", {"object.d.color=[1,0,0]"}).objects[0].temperature, 0);
    EXPECT_EQ(load(head + "name = \"d\"\ncolor = [1, 0, 0]", {"object.d.temperature=7000"}).objects[0].temperature,
              7000);
    for (const SceneDescription& scene : {hot, colored}) {
        const SceneDescription reloaded = load(print_scene(scene));
        EXPECT_EQ(print_scene(reloaded), print_scene(scene));
        EXPECT_EQ(reloaded.objects[0].shape, Shape::disk);
        EXPECT_EQ(reloaded.objects[0].outer, 4);
        EXPECT_EQ(reloaded.objects[0].temperature, scene.objects[0].temperature);
    }
}

TEST_F(LoadScene, NamesTheDebianPackageOfMissingModels) {
    const std::string mesh = "shape = \"mesh\"\nfile = \"/usr/share/assimp/models/OBJ/no.obj\"";
    EXPECT_NE(refusal(edited("shape = \"sphere\"\ncenter = [1, 0, 0]\nradius = 0.25", mesh.c_str()))
                  .find("assimp-testmodels"),
              std::string::npos);
}

TEST_F(LoadScene, RefusesMissingFilesAndFolders) {
    EXPECT_THROW(load_scene((directory_ / "none.toml").string(), {}, small_catalogue()), InputError);
    EXPECT_THROW(load_scene(directory_.string(), {}, small_catalogue()), InputError);
}

// The overrides state no method: trial rays or the defaults determine it. The printed scene must not state a method.
TEST_F(LoadScene, ReadsAPrintedSceneWithoutAStatedMethod) {
    for (const std::vector<Override>& overrides :
         {std::vector<Override>{"integrator.max_pixel_error=0.25"}, {"integrator.rescale=none"}}) {
        const SceneDescription scene = load(good_scene, overrides);
        const SceneDescription reloaded = load(print_scene(scene));
        EXPECT_EQ(reloaded.integrator.method_location.has_value(), scene.integrator.method_location.has_value())
            << overrides[0].text;
        EXPECT_EQ(reloaded.integrator.method, scene.integrator.method);
        EXPECT_EQ(reloaded.integrator.step, scene.integrator.step);
        EXPECT_EQ(print_scene(reloaded), print_scene(scene));
    }
}

TEST_F(LoadScene, ReadsThePrintedSceneAsTheSameScene) {
    const std::vector<Override> overrides{"space.rg=0.1234567890123456789",
                                          "space.center=[1e-300, 100000, -0.1]",
                                          "sky.checker=true",
                                          "integrator.max_steps=4294967295",
                                          "integrator.hit=chord",
                                          "integrator.cull=none",
                                          "integrator.refill=on",
                                          "integrator.max_pixel_error=0.25",
                                          "camera.type=orthographic",
                                          "camera.height=3.5",
                                          "film.spp=16",
                                          "film.seed=4294967295",
                                          "object.ball.name='a \"b\"\\\t'",
                                          "film.layers=['steps', 'color']"};
    const SceneDescription scene = load(good_scene, overrides);
    const std::string printed = print_scene(scene);
    const SceneDescription reloaded = load(printed);
    EXPECT_EQ(print_scene(reloaded), printed);
    EXPECT_EQ(reloaded.space.parameters, scene.space.parameters);
    EXPECT_EQ(reloaded.space.center, scene.space.center);
    EXPECT_EQ(reloaded.integrator.max_steps, scene.integrator.max_steps);
    EXPECT_EQ(reloaded.integrator.method, scene.integrator.method);
    EXPECT_EQ(reloaded.integrator.step, scene.integrator.step);
    EXPECT_EQ(reloaded.integrator.hit, scene.integrator.hit);
    EXPECT_EQ(reloaded.integrator.cull, scene.integrator.cull);
    EXPECT_EQ(reloaded.integrator.refill, scene.integrator.refill);
    EXPECT_EQ(reloaded.integrator.max_pixel_error, scene.integrator.max_pixel_error);
    EXPECT_EQ(reloaded.camera.position, scene.camera.position);
    EXPECT_EQ(reloaded.camera.type, scene.camera.type);
    EXPECT_EQ(reloaded.camera.height, 3.5);
    EXPECT_EQ(reloaded.film.spp, 16u);
    EXPECT_EQ(reloaded.film.seed, 4294967295u);
    EXPECT_EQ(reloaded.film.layers, scene.film.layers);
    EXPECT_EQ(reloaded.sky.paint.kind, Paint::Kind::checker);
    ASSERT_EQ(reloaded.objects.size(), scene.objects.size());
    EXPECT_EQ(reloaded.objects[0].name, "a \"b\"\\\t");
    for (std::size_t i = 0; i < 6; ++i) {
        EXPECT_EQ(reloaded.objects[2].faces[i].kind, scene.objects[2].faces[i].kind);
        EXPECT_EQ(reloaded.objects[2].faces[i].color, scene.objects[2].faces[i].color);
        EXPECT_EQ(reloaded.objects[2].faces[i].checker, scene.objects[2].faces[i].checker);
    }
}

TEST(NearMatch, CountsSwappedLettersAsOneEdit) {
    EXPECT_EQ(edit_distance("", "abc"), 3u);
    EXPECT_EQ(edit_distance("gauss8", "guass8"), 1u);
    EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
    EXPECT_EQ(near_match("veret", {"verlet", "gauss8"}), "verlet");
    EXPECT_EQ(near_match("xyz", {"verlet", "gauss8"}), "");
}

}  // namespace kagero::test
