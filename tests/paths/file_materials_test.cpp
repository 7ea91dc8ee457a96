// Tests of materials = "file": pixels of meshes whose materials are in glTF and MTL files, against colours that are
// computed here from the numbers in the files.
#include "tests/support/file_materials.h"

namespace kagero::test {
namespace {

TEST_F(FileMaterials, GltfColours) {
    const json metal = {{"pbrMetallicRoughness", {{"baseColorFactor", {0.9, 0.6, 0.3, 1}}}}},
               glossy = {{"extensions",
                          {{"KHR_materials_pbrSpecularGlossiness", {{"diffuseFactor", {0.25, 0.5, 0.75, 1}}}}}}};
    Squares squares;
    squares.add(diffuse({0.2, 0.5, 0.7, 1})).add(metal).add(glossy).add(nullptr);
    render_squares(squares, 4);
    expect_square(0, {0.2 * sky, 0.5 * sky, 0.7 * sky});
    expect_square(1, {0.9 * sky, 0.6 * sky, 0.3 * sky});
    expect_square(2, {0.25 * sky, 0.5 * sky, 0.75 * sky});
    expect_square(3, {sky, sky, sky});  // the default material is a white metal
    EXPECT_EQ(materials_, (std::vector<Material>{Material::surface, Material::diffuse, Material::mirror,
                                                 Material::diffuse, Material::mirror}));
    EXPECT_NE(remarks_.find("roughness is not used"), std::string::npos) << remarks_;
    EXPECT_NE(remarks_.find("glossiness"), std::string::npos) << remarks_;
}

/// Emitters in the plane of the squares do not light them, but some rays are sent toward them, so pixels have noise.
TEST_F(FileMaterials, GltfEmission) {
    json emitting = diffuse({0.4, 0.5, 0.6, 1});
    emitting["emissiveFactor"] = {0.1, 0.2, 0.3};
    json strong = emitting, glowing_mirror = {{"emissiveFactor", {0.5, 0, 0}}};
    strong["extensions"] = {{"KHR_materials_emissive_strength", {{"emissiveStrength", 5}}}};
    json unlit = diffuse({0.3, 0.7, 0.1, 1});
    unlit["extensions"] = {{"KHR_materials_unlit", json::object()}};
    Squares squares;
    squares.add(emitting).add(strong).add(unlit).add(glowing_mirror);
    spp_ = 4096;
    render_squares(squares, 4);
    expect_noisy_square(0, {0.4 * sky + 0.1, 0.5 * sky + 0.2, 0.6 * sky + 0.3});
    expect_noisy_square(1, {0.4 * sky + 0.5, 0.5 * sky + 1.0, 0.6 * sky + 1.5});
    expect_square(2, {0.3, 0.7, 0.1});
    expect_square(3, {sky + 0.5, sky, sky});
    EXPECT_EQ(materials_[3], Material::surface);
    EXPECT_EQ(materials_[4], Material::mirror);
}

/// Renders the same textured square from a file, from a data URI and from a part of a buffer.
TEST_F(FileMaterials, GltfTexturesFromFilesAndEmbedded) {
    json material = textured({{"index", 0}});
    material["pbrMetallicRoughness"]["baseColorFactor"] = {0.5, 1, 0.25, 1};
    for (const int storage : {0, 1, 2}) {
        Squares squares;
        squares.add(material).set("textures", one_texture);
        if (storage == 0) squares.set("images", texture_file);
        if (storage == 1) squares.set("images", {{{"uri", "data:image/png;base64," + base64(png())}}});
        if (storage == 2)
            squares.set("images", {{{"bufferView", squares.parts.add_view(png())}, {"mimeType", "image/png"}}});
        render_squares(squares, 1);
        for (int row : {0, 1})
            for (int column : {0, 1})
                expect_pixel(std::size_t(column), std::size_t(row),
                             product({0.5 * sky, sky, 0.25 * sky}, texel(row, column)));
    }
}

TEST_F(FileMaterials, GltfTextureCoordinates) {
    const auto moved = [](const json& transform) {
        return textured({{"index", 0}, {"extensions", {{"KHR_texture_transform", transform}}}});
    };
    const json mirrored_second_set = textured({{"index", 1}, {"texCoord", 1}}),
               clamped_second_set = textured({{"index", 2}, {"texCoord", 1}});
    Squares squares;
    squares.add(moved({{"offset", {0.5, 0}}})).add(moved({{"offset", {0, 1}}, {"rotation", std::acos(0.0)}}));
    squares.add(mirrored_second_set).add(clamped_second_set).add(moved({{"texCoord", 1}, {"offset", {-0.5, 0}}}));
    squares.set("textures", {{{"source", 0}}, {{"source", 0}, {"sampler", 0}}, {{"source", 0}, {"sampler", 1}}});
    squares.set("samplers", {{{"wrapS", 33648}, {"wrapT", 33648}}, {{"wrapS", 33071}, {"wrapT", 10497}}});
    squares.set("images", texture_file);
    render_squares(squares, 5);
    for (int row : {0, 1})
        for (int column : {0, 1}) {
            const auto expect = [&](std::size_t square, const Double3& color) {
                expect_pixel(2 * square + std::size_t(column), std::size_t(row), scaled(color, sky));
            };
            expect(0, texel(row, column + 1));
            // The image, turned clockwise by 90° about the upper left corner of its repetitions and moved down by one:
            // (u, v) becomes (v, 1 − u), with v downward.
            expect(1, texel(1 - column, row));
            expect(2,
                   texel(row, column + 4, true));  // the second set begins at u = 2, a repetition that is not mirrored
            expect(3, texel(row, 1));
            expect(4, texel(row, column + 3));
        }
}

TEST_F(FileMaterials, GltfMirroredRepetition) {
    Squares squares;
    json material = textured({{"index", 0}, {"extensions", {{"KHR_texture_transform", {{"offset", {1, -1}}}}}}});
    squares.add(material).set("images", texture_file).set("textures", {{{"source", 0}, {"sampler", 0}}});
    squares.set("samplers", {{{"wrapS", 33648}, {"wrapT", 33648}}});
    render_squares(squares, 1);
    for (int row : {0, 1})
        for (int column : {0, 1})
            expect_pixel(std::size_t(column), std::size_t(row), scaled(texel(1 - row, 1 - column), sky));
}

TEST_F(FileMaterials, GltfEmissionTextureAndMetalTexture) {
    json emitting = diffuse({0, 0, 0, 1});
    emitting["emissiveFactor"] = {1, 0.5, 1};
    emitting["emissiveTexture"] = {{"index", 0}};
    json metal = {
        {"pbrMetallicRoughness", {{"metallicRoughnessTexture", {{"index", 0}}}, {"baseColorTexture", {{"index", 0}}}}}};
    Squares squares;
    squares.add(emitting).add(metal).set("textures", one_texture).set("images", texture_file);
    render_squares(squares, 2);
    for (int row : {0, 1})
        for (int column : {0, 1})
            expect_pixel(std::size_t(column), std::size_t(row), product({1, 0.5, 1}, texel(row, column)));
    const double mean = (64 + 30 + 250 + 80) / 4.0 / 255;  // of the blue channel, as it is stored
    ASSERT_LT(mean, 0.5);
    EXPECT_EQ(materials_.back(), Material::diffuse);
    EXPECT_NE(remarks_.find("materials[1] is metallic by 0.41568"), std::string::npos) << remarks_;
}

/// With material = "surface", the colours of the file are the light of the object, and nothing scatters.
TEST_F(FileMaterials, SurfacesWithTheColoursOfTheFile) {
    Squares squares;
    json emitting = diffuse({0.4, 0.5, 0.6, 1});
    emitting["emissiveFactor"] = {0.1, 0.2, 0.3};
    squares.add(emitting).add({{"pbrMetallicRoughness", {{"baseColorFactor", {0.9, 0.6, 0.3, 1}}}}});
    render_scene(
        scene(write("model.gltf", embedded(squares.parts)), 2, "materials = \"file\"\nmaterial = \"surface\"\n"));
    expect_square(0, {0.4, 0.5, 0.6});
    expect_square(1, {0.9, 0.6, 0.3});
    for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(film_->plane("object")[i], 2) << "the number of the whole object";
    EXPECT_NE(remarks_.find("materials[0] emits light, which is left out"), std::string::npos) << remarks_;
}

TEST_F(FileMaterials, MtlColoursTexturesAndMetal) {
    write("texture.png", png());
    write("my colours.mtl",
          "newmtl red paint\nKd 0.7 0.1 0.05\nKs 1 1 1\nnewmtl picture\nmap_Kd -o 0.5 0 0 -s 1 1 1 .\\texture.png\n"
          "newmtl lamp\nKd 0.5\nnewmtl chrome\nKd 0.8 0.7 0.6\nPm 1\nPr 0.1\nfancy 1\n");
    render_scene(scene(write("model.obj", obj), 4));
    expect_square(0, {0.7 * sky, 0.1 * sky, 0.05 * sky});
    for (int row : {0, 1})
        for (int column : {0, 1})
            expect_pixel(std::size_t(2 + column), std::size_t(row), scaled(texel(row, column + 1), sky));
    expect_square(2, {0.5 * sky, 0.5 * sky, 0.5 * sky});
    expect_square(3, {0.8 * sky, 0.7 * sky, 0.6 * sky});
    EXPECT_EQ(materials_.back(), Material::mirror);
    for (const char* unused : {"Ks is not used", "roughness is not used", "the statement \"fancy\" is not used"})
        EXPECT_NE(remarks_.find(unused), std::string::npos) << remarks_;
}

TEST_F(FileMaterials, MtlEmission) {
    write("my colours.mtl",
          "newmtl red paint\nKd 0.5\nnewmtl picture\nKd 0\nKe 0.5 1 0.25\nmap_Ke texture.png\n"
          "newmtl lamp\nKd 0.5\nKe 2 3 4\nnewmtl chrome\nKd 0\n");
    write("texture.png", png());
    spp_ = 4096;
    render_scene(scene(write("model.obj", obj), 4));
    expect_noisy_square(0, {0.5 * sky, 0.5 * sky, 0.5 * sky});
    expect_noisy_square(2, {0.5 * sky + 2, 0.5 * sky + 3, 0.5 * sky + 4});
    // The mean of bilinear interpolation over the whole texture, which repeats, is the mean of its texels.
    const Double3 factor{0.5, 1, 0.25};
    Double3 mean{};
    for (std::size_t i = 0; i < 4; ++i) mean = add(mean, scaled(pixel(2 + i % 2, i / 2), 0.25));
    for (std::size_t k = 0; k < 3; ++k) {
        const double expected = 0.25 * (texel(0, 0)[k] + texel(0, 1)[k] + texel(1, 0)[k] + texel(1, 1)[k]);
        EXPECT_NEAR(mean[k], factor[k] * expected, 0.01);
    }
}

/// The mesh itself does not depend on its materials, and materials are not read unless they are used.
TEST_F(FileMaterials, IgnoresMaterialsOfTheFileUnlessRequested) {
    const std::string file = write("model.gltf", embedded(Squares().add(diffuse({7, 1, 1, 1})).parts));
    render_scene(scene(file, 1, "color = [0.1, 0.2, 0.3]\n"));
    expect_square(0, {0.1, 0.2, 0.3});
    EXPECT_EQ(remarks_, "");
}

}  // namespace
}  // namespace kagero::test
