// Tests of materials = "file": what is refused, with the file and the material in the message.
#include "tests/support/file_materials.h"

namespace kagero::test {
namespace {

TEST_F(FileMaterials, RefusesMtlFilesByName) {
    struct Case {
        std::string mtl, message;
    };
    const std::string others = "newmtl picture\nnewmtl lamp\nnewmtl chrome\n";
    for (const Case& wrong :
         std::vector<Case>{{others, "model.obj:16: OBJ: the material \"red paint\" is not in the files of mtllib"},
                           {"Kd 1 1 1\n", "my colours.mtl:1: MTL: \"Kd\" stands before the first newmtl"},
                           {"newmtl red paint\nKd 1.5 0 0\n",
                            "my colours.mtl:2: MTL: material \"red paint\": Kd has the value \"1.5\""},
                           {"newmtl red paint\nKd 1 0\n", "Kd has 2 numbers; it needs 3"},
                           {"newmtl red paint\nKd spectral a.rfl\n",
                            "which is not supported; state red, green and blue"},
                           {"newmtl red paint\nmap_Kd -mm 0 1 a.png\n", "the option -mm of a texture is not supported"},
                           {"newmtl red paint\nmap_Kd\n", "map_Kd names no image"},
                           {"newmtl red paint\nmap_Kd a.png\nmap_Ke -s 2 2 a.png\n", "different values of -s or -o"},
                           {"newmtl\n", "newmtl has no name"},
                           {"newmtl red paint\nmap_Kd missing.png\n" + others, "material \"red paint\" of "}}) {
        write("my colours.mtl", wrong.mtl);
        const std::string message = refusal_of(scene(write("model.obj", obj), 4));
        EXPECT_NE(message.find(wrong.message), std::string::npos) << wrong.mtl << message;
        EXPECT_NE(message.find("toml:2"), std::string::npos) << "the key file: " << wrong.mtl << message;
    }
    std::filesystem::remove(directory_ / "my colours.mtl");
    EXPECT_NE(refusal_of(scene(write("model.obj", obj), 4)).find("my: MTL: the file cannot be read"),
              std::string::npos);
}

TEST_F(FileMaterials, RefusesGltfMaterialsByName) {
    const auto named = [](json material) {
        material["name"] = "Wood";
        return material;
    };
    const auto with = [&](const char* key, const json& value) {
        json material = named(diffuse({1, 1, 1, 1}));
        material[key] = value;
        return material;
    };
    struct Case {
        json material;
        std::string message;
    };
    for (const Case& wrong : std::vector<Case>{
             {named(diffuse({1, 2, 1, 1})), "baseColorFactor has the value 2; the legal range is 0 <= value <= 1"},
             {named(diffuse({1, 1, 1})), "must be an array of 4 numbers"},
             {named({{"pbrMetallicRoughness", {{"metallicFactor", "all"}}}}), "metallicFactor = \"all\" is not legal"},
             {named(textured({{"index", 9}})), "is not an index of textures"},
             {named(textured(json::object())), "baseColorTexture has no index"},
             {named(textured({{"index", 1}})), "which has no source; an extension"},
             {named(textured({{"index", 2}})), "wrapS = 5 is not legal"},
             {named(textured({{"index", 0}, {"extensions", {{"KHR_texture_transform", {{"rotation", "x"}}}}}})),
              "rotation must be a number"},
             {with("emissiveFactor", {-1, 0, 0}), "emissiveFactor has the value -1"},
             {with("extensions", 3), "extensions must be an object"},
             {named({{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"baseColorTexture", {{"index", 0}}}}},
                     {"emissiveFactor", {1, 1, 1}},
                     {"emissiveTexture", {{"index", 0}, {"texCoord", 1}}}}),
              "emissiveTexture and baseColorTexture use different texture coordinates, which is not supported"},
             {named(textured({{"index", 0}})), "missing.png"}}) {
        Squares squares;
        squares.add(wrong.material).set("images", {{{"uri", "missing.png"}}});
        squares.set("textures", {{{"source", 0}}, json::object(), {{"source", 0}, {"sampler", 0}}});
        squares.set("samplers", {{{"wrapS", 5}}});
        const std::string message = refusal_of(scene(write("model.gltf", embedded(squares.parts)), 1));
        EXPECT_NE(message.find(wrong.message), std::string::npos) << wrong.material << message;
        EXPECT_NE(message.find("materials[0] \"Wood\""), std::string::npos) << wrong.material << message;
        EXPECT_NE(message.find("model.gltf"), std::string::npos) << message;
    }
}

TEST_F(FileMaterials, RefusesKeysThatDoNotSuit) {
    const std::string file = write("model.gltf", embedded(Squares().add(diffuse({1, 1, 1, 1})).parts));
    const std::string materials = "materials = \"file\"\n";
    for (const auto& [keys, message] : std::vector<std::pair<std::string, std::string>>{
             {"materials = \"fil\"\n", "did you mean \"file\""},
             {materials + "color = [1, 1, 1]\n", "object.model.color is not legal with materials"},
             {materials + "tint = [1, 1, 1]\n", "object.model.tint is not legal with materials"},
             {materials + "material = \"mirror\"\n", "object.model.material = \"mirror\" is not legal"},
             {materials + "shading = \"lambert\"\n", "only if material = \"surface\" is stated too"}})
        EXPECT_NE(refusal_of(scene(file, 1, keys)).find(message), std::string::npos) << keys;
    EXPECT_NE(refusal_of(scene(write("model.ply", "ply\n"), 1)).find("PLY files contain no materials"),
              std::string::npos);
    const auto printed = print_scene(load_scene(write("scene.toml", scene(file, 1)), {}, catalogue("auto")));
    EXPECT_NE(printed.find("materials = \"file\"\n"), std::string::npos);
    EXPECT_EQ(print_scene(load_scene(write("again.toml", printed), {}, catalogue("auto"))), printed);
}

}  // namespace
}  // namespace kagero::test
