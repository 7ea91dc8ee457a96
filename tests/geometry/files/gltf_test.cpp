// Tests of glTF files that occur in the field: every file must give the stated triangles, or a refusal with a reason.
#include "tests/support/gltf_fixture.h"

namespace kagero::test {

TEST_F(GltfFile, ReadsUnusualAccessors) {
    const auto indices = [](auto type, int code) {
        return [type, code](Parts& p) {
            using Number = decltype(type);
            p.primitive()["indices"] = p.add_accessor(Bytes().add<Number>({0, 1, 2, 0, 2, 3}).text, code, 6, "SCALAR");
        };
    };
    const Change changes[] = {
        {"plain", [](Parts&) {}, two, ""},
        {"uint8", indices(std::uint8_t{}, 5121), two, ""},
        {"uint32", indices(std::uint32_t{}, 5125), two, ""},
        {"real-count", [](Parts& p) { p.accessor(1)["count"] = 6.0; }, two, ""},
        {"no-indices",
         [](Parts& p) {
             p.primitive().erase("indices");
             p.accessor(0)["count"] = 3;
         },
         one, ""},
        {"stride",
         [](Parts& p) {
             const auto view = p.add_view(Bytes().add<float>({9, 9, 0, 0, 1, 9, 9, 9, 1, 0, 1, 9, 9, 9, 1, 1, 1}).text);
             p.file["bufferViews"][view]["byteStride"] = 24;
             p.accessor(0) = {
                 {"bufferView", view}, {"byteOffset", 8}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}};
             p.accessor(1)["count"] = 3;
         },
         one, ""},
        {"stride-zero", [](Parts& p) { p.file["bufferViews"][0]["byteStride"] = 0; }, two, ""},
        {"odd-offset",
         [](Parts& p) {
             p.primitive()["indices"] =
                 p.add_accessor('\7' + Bytes().add<std::uint32_t>({0, 1, 2}).text, 5125, 3, "SCALAR");
             p.file["accessors"].back()["byteOffset"] = 1;
         },
         one, ""},
        {"index-offset",
         [](Parts& p) {
             p.accessor(1)["byteOffset"] = 6;
             p.accessor(1)["count"] = 3;
         },
         "0 0 1, 1 1 1, 0 1 1", ""},
        {"sparse",
         [](Parts& p) {
             p.accessor(0)["sparse"] = {
                 {"count", 2},
                 {"indices",
                  {{"bufferView", p.add_view(std::string("\0\1\3", 3))}, {"byteOffset", 1}, {"componentType", 5121}}},
                 {"values",
                  {{"bufferView", p.add_view(Bytes().add<float>({9, 2, 0, 1, 0, 2, 1}).text)}, {"byteOffset", 4}}}};
         },
         "0 0 1, 1 1 1, 0 2 1 | 0 0 1, 2 0 1, 1 1 1", ""},
        {"sparse-only",
         [](Parts& p) {
             p.accessor(0).erase("bufferView");
             p.accessor(0)["sparse"] = {
                 {"count", 2},
                 {"indices",
                  {{"bufferView", p.add_view(Bytes().add<std::uint32_t>({1, 3}).text)}, {"componentType", 5125}}},
                 {"values", {{"bufferView", p.add_view(Bytes().add<float>({2, 0, 1, 0, 2, 1}).text)}}}};
             p.primitive()["indices"] = p.add_accessor(std::string("\0\1\3", 3), 5121, 3, "SCALAR");
         },
         "0 0 0, 2 0 1, 0 2 1", ""},
        {"sparse-indices",
         [](Parts& p) {
             p.accessor(1)["sparse"] = {{"count", 1},
                                        {"indices", {{"bufferView", p.add_view("\5")}, {"componentType", 5121}}},
                                        {"values", {{"bufferView", p.add_view(Bytes().add<std::uint16_t>({4}).text)}}}};
         },
         "0 0 1, 1 0 1, 1 1 1 | 0 0 1, 1 1 1, 0 1 5", ""},
        {"quantized",
         [](Parts& p) {
             p.file["extensionsRequired"] = {"KHR_mesh_quantization"};
             p.primitive()["attributes"]["POSITION"] =
                 p.add_accessor(Bytes().add<std::uint16_t>({0, 0, 1, 0, 1, 0, 1, 0, 1, 1, 1, 0, 0, 1, 1, 0}).text, 5123,
                                4, "VEC3");
             p.file["bufferViews"].back()["byteStride"] = 8;
         },
         two, ""},
        {"quantized-int8",
         [](Parts& p) {
             p.file["extensionsUsed"] = {"KHR_mesh_quantization"};
             p.primitive()["attributes"]["POSITION"] =
                 p.add_accessor(Bytes().add<std::int8_t>({-1, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1}).text, 5120, 4, "VEC3");
         },
         "-1 0 1, 1 0 1, 1 1 1 | -1 0 1, 1 1 1, 0 1 1", ""},
        {"normalized-int16",
         [](Parts& p) {
             p.file["extensionsRequired"] = {"KHR_mesh_quantization"};
             p.primitive()["attributes"]["POSITION"] = p.add_accessor(
                 Bytes().add<std::int16_t>({-32768, 0, 32767, 32767, 0, 32767, 32767, 32767, 32767, 0, 0, -32767}).text,
                 5122, 4, "VEC3");
             p.file["accessors"].back()["normalized"] = true;
         },
         "-1 0 1, 1 0 1, 1 1 1 | -1 0 1, 1 1 1, 0 0 -1", ""},
        {"normalized-uint8",
         [](Parts& p) {
             p.file["extensionsRequired"] = {"KHR_mesh_quantization"};
             p.primitive()["attributes"]["POSITION"] =
                 p.add_accessor(Bytes().add<std::uint8_t>({0, 0, 255, 255, 0, 255, 255, 255, 255, 51, 51, 51}).text,
                                5121, 4, "VEC3");
             p.file["accessors"].back()["normalized"] = true;
         },
         "0 0 1, 1 0 1, 1 1 1 | 0 0 1, 1 1 1, 0.2 0.2 0.2", ""},
    };
    expect_all(changes);
}

TEST_F(GltfFile, ReadsModesNodesAndScenes) {
    const auto mode = [](int code, std::initializer_list<std::uint8_t> corners) {
        const std::string data(corners.begin(), corners.end());
        return [code, data](Parts& p) {
            p.primitive()["mode"] = code;
            p.primitive()["indices"] = p.add_accessor(data, 5121, static_cast<int>(data.size()), "SCALAR");
        };
    };
    const auto add_lines = [](int code) {
        return [code](Parts& p) {
            json lines = p.primitive();
            lines["mode"] = code;
            p.file["meshes"][0]["primitives"].push_back(lines);
        };
    };
    const double h = std::sqrt(0.5);
    const Change changes[] = {
        {"strip", mode(5, {1, 2, 0, 3}), "0 0 1, 1 0 1, 1 1 1 | 0 0 1, 1 1 1, 0 1 1", ""},
        {"strip-joined", mode(5, {0, 1, 2, 2, 0, 2, 3}), two, ""},
        {"strip-parity", mode(5, {0, 1, 2, 2, 0, 0, 2, 3}), "0 0 1, 0 1 1, 1 1 1 | 0 0 1, 1 0 1, 1 1 1", ""},
        {"fan", mode(6, {0, 1, 2, 3}), two, ""},
        {"fan-short", mode(6, {0, 1}), "", "has no triangle"},
        {"points", add_lines(0), two, "6 points or lines were left out"},
        {"lines", add_lines(1), two, "3 points or lines were left out"},
        {"loop", add_lines(2), two, "6 points or lines were left out"},
        {"line-strip", add_lines(3), two, "5 points or lines were left out"},
        {"incomplete", [](Parts& p) { p.accessor(1)["count"] = 5; }, one, "not a multiple of 3"},
        {"two-primitives",
         [](Parts& p) {
             json second = p.primitive();
             p.accessor(1)["count"] = 3;
             p.file["accessors"].push_back(p.accessor(1));
             p.file["accessors"].back()["byteOffset"] = 6;
             second["indices"] = 2;
             p.file["meshes"][0]["primitives"].push_back(second);
         },
         two, ""},
        {"two-meshes",
         [](Parts& p) {
             p.file["meshes"].push_back(p.file["meshes"][0]);
             p.accessor(1)["count"] = 3;
             p.file["nodes"] = {{{"mesh", 0}, {"children", {1}}}, {{"mesh", 1}, {"translation", {0, 0, 4}}}};
         },
         one + " | 0 0 5, 1 0 5, 1 1 5", ""},
        {"one-mesh-twice",
         [](Parts& p) {
             p.accessor(1)["count"] = 3;
             p.file["scenes"][0]["nodes"] = {0, 1};
             p.file["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}, {"scale", {2, 1, 1}}}};
         },
         one + " | 0 0 1, 2 0 1, 2 1 1", ""},
        {"matrix",
         [](Parts& p) {
             p.accessor(1)["count"] = 3;
             p.file["nodes"][0]["matrix"] = {0, 2, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1};
         },
         "4 8 8, 5 6 8, 5 8 8", ""},
        {"rotation",
         [h](Parts& p) {
             p.accessor(1)["count"] = 3;
             p.file["nodes"][0]["rotation"] = {0, 0, h, h};  // a quarter of a turn about z
             p.file["nodes"][0]["scale"] = {2, 1, 1};
             p.file["nodes"][0]["translation"] = {10, 0, 0};
         },
         "10 0 1, 10 2 1, 9 2 1", ""},
        {"chain",
         [](Parts& p) {
             p.accessor(1)["count"] = 3;
             p.file["nodes"] = {{{"children", {1}}, {"rotation", {0, 0, 1, 0}}},
                                {{"children", {2}}, {"translation", {10, 0, 0}}},
                                {{"mesh", 0}}};
         },
         "-10 0 1, -11 0 1, -11 -1 1", ""},
        {"second-scene",
         [](Parts& p) {
             p.accessor(1)["count"] = 3;
             p.file["scene"] = 1;
             p.file["scenes"].push_back({{"nodes", {1}}});
             p.file["nodes"].push_back({{"mesh", 0}, {"scale", {3, 3, 1}}});
         },
         "0 0 1, 3 0 1, 3 3 1", ""},
        {"no-default-scene", [](Parts& p) { p.file.erase("scene"); }, two, ""},
        {"two-scenes",
         [](Parts& p) {
             p.file.erase("scene");
             p.file["scenes"].push_back(json::object());
         },
         two, "2 scenes are in the file"},
        {"skin", [](Parts& p) { p.file["nodes"][0]["skin"] = 0; }, two, "1 meshes have a skin"},
        {"morph",
         [](Parts& p) {
             p.primitive()["targets"] = {{{"POSITION", 0}}};
         },
         two, "1 parts have morph targets"},
        {"more",
         [](Parts& p) {
             p.file["nodes"].push_back({{"camera", 0}, {"name", "W\xc3\xbcrfel"}});
             p.file["cameras"] = {{{"type", "perspective"}}};
             p.file["images"] = {{{"uri", "none.png"}}};
             p.file["extensionsUsed"] = {"KHR_lights_punctual"};
             p.primitive()["material"] = 0;
             p.primitive()["attributes"]["_OWN"] = 99;
         },
         two, ""},
    };
    expect_all(changes);
}

TEST_F(GltfFile, ReadsBuffersOfAllKinds) {
    const Parts parts = two_triangles();
    write("name with %.bin", parts.bytes + "more");
    const auto external = [&](const std::string& uri) {
        Parts changed = parts;
        changed.file["buffers"] = {{{"byteLength", parts.bytes.size()}, {"uri", uri}}};
        return changed.file.dump();
    };
    Parts unused = parts;
    unused.file["buffers"] = {{{"byteLength", parts.bytes.size()}}, {{"byteLength", 9}, {"uri", "none.bin"}}};
    const std::string whole = binary(parts);
    const MeshFileCase cases[] = {
        {"bom.gltf", "\xef\xbb\xbf" + embedded(parts), two, ""},
        {"external.gltf", external("name%20with%20%25.bin"), two, ""},
        {"plain.gltf", external("name with %.bin"), two, ""},
        {"missing.gltf", external("none.bin"), "", "buffers[0].uri = \"none.bin\": there is no file"},
        {"folder.gltf", external(""), "", "there is no file"},
        {"device.gltf", external("/dev/zero"), "", "there is no file"},
        {"address.gltf", external("https://example.org/a.bin"), "", "is not the path of a file"},
        {"not-base64.gltf", external("data:application/gltf-buffer,abc"), "", "embedded data must be base64"},
        {"wrong-base64.gltf", external("data:;base64,AAA*"), "", "embedded data must be base64"},
        {"short-base64.gltf", external("data:;base64,AAAA"), "", "but there are only 3 bytes"},
        {"binary.glb", whole, two, ""},
        {"zeros.glb", binary(parts, '\0'), two, ""},
        {"name.gltf", whole, two, ""},
        {"text.glb", embedded(parts), two, ""},
        {"embedded.glb", glb(chunk(embedded(parts), json_type, ' ')), two, ""},
        {"unknown-chunk.glb",
         [&] {
             Parts changed = parts;
             changed.file["buffers"] = {{{"byteLength", parts.bytes.size()}}};
             return glb(chunk(changed.file.dump(), json_type, ' ') + chunk("else", 0x12345678, ' ') +
                        chunk(parts.bytes, binary_type, '\0'));
         }(),
         two, ""},
        {"unused-buffer.glb", glb(chunk(unused.file.dump(), json_type, ' ') + chunk(parts.bytes, binary_type, '\0')),
         two, ""},
        {"more.glb", whole + "more", two, ""},
        {"empty-chunk.glb", glb(chunk(unused.file.dump(), json_type, ' ') + chunk("", binary_type, ' ')), "",
         "but there are only 0 bytes"},
        {"no-chunk.glb", glb(chunk(unused.file.dump(), json_type, ' ')), "", "buffers[0] has no data"},
        {"version.glb", "glTF" + Bytes().add<std::uint32_t>({1}).text + whole.substr(8), "", "the legal version is 2"},
        {"first.glb", glb(chunk(parts.bytes, binary_type, '\0')), "", "the JSON chunk must be the first"},
    };
    for (const MeshFileCase& file : cases) expect(file);
    for (std::size_t size = 4; size < whole.size(); ++size)
        expect({"cut.glb", whole.substr(0, size), "", "it is truncated"});
}

TEST_F(GltfFile, ReadsNormalsAndTextureCoordinates) {
    Parts parts = two_triangles();
    parts.accessor(0)["count"] = 3;
    parts.accessor(1)["count"] = 3;
    json& attributes = parts.primitive()["attributes"];
    attributes["NORMAL"] = parts.add_accessor(Bytes().add<float>({0, 0, 2, 1, 0, 0, NAN, 0, 1}).text, 5126, 3, "VEC3");
    attributes["TEXCOORD_0"] = parts.add_accessor(Bytes().add<float>({0, .25, 1, 0, .5, 1}).text, 5126, 3, "VEC2");
    const TriangleMesh read = mesh("all.gltf", embedded(parts));
    EXPECT_EQ(read.uv, (std::vector<double>{0, .75, 1, 1, .5, 0})) << "v increases upward";
    EXPECT_EQ(read.normals, (std::vector<double>{0, 0, 1, 1, 0, 0, 0, 0, 0}));
    attributes["TEXCOORD_0"] =
        parts.add_accessor(Bytes().add<std::uint16_t>({0, 13107, 65535, 0, 0, 65535}).text, 5123, 3, "VEC2");
    parts.file["accessors"].back()["normalized"] = true;
    EXPECT_EQ(mesh("normalized.gltf", embedded(parts)).uv, (std::vector<double>{0, .8, 1, 1, 0, 0}));
    EXPECT_TRUE(remarks_.empty());
}

}  // namespace kagero::test
