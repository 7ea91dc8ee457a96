// Tests of wrong glTF files: every one must be refused with a reason, without reading beyond a buffer.
#include "tests/support/gltf_fixture.h"

namespace kagero::test {

TEST_F(GltfFile, RefusesWrongFiles) {
    const auto set = [](const std::string& pointer, const json& value) {
        return [pointer, value](Parts& p) { p.file[json::json_pointer(pointer)] = value; };
    };
    const auto erase = [](const std::string& parent, const std::string& key) {
        return [parent, key](Parts& p) { p.file[json::json_pointer(parent)].erase(key); };
    };
    const Change changes[] = {
        {"draco", set("/extensionsRequired", {"KHR_draco_mesh_compression"}), "",
         "requires the extension \"KHR_draco_mesh_compression\""},
        {"second-extension", set("/extensionsRequired", {"KHR_mesh_quantization", "EXT_meshopt_compression"}), "",
         "requires the extension \"EXT_meshopt_compression\""},
        {"unnamed-quantized", set("/accessors/0/componentType", 5123), "", "legal are 5126"},
        {"version", set("/asset/version", "1.0"), "", "asset.version = \"1.0\""},
        {"no-version", erase("", "asset"), "", "the legal version is 2.0"},
        {"no-scene", erase("", "scenes"), "", "it contains no scene"},
        {"scene-index", set("/scene", 3), "", "scene = \"3\" is not an index of scenes; the file has 1"},
        {"node-index", set("/scenes/0/nodes", {7}), "", "scenes[0].nodes = \"7\" is not an index of nodes"},
        {"negative-node", set("/scenes/0/nodes", {-1}), "", "scenes[0].nodes = \"-1\""},
        {"node-twice", set("/scenes/0/nodes", {0, 0}), "", "node 0 occurs twice"},
        {"deep",
         [](Parts& p) {
             for (int i = 0; i < 1100; ++i) {
                 p.file["nodes"][i]["children"] = {i + 1.0};
                 p.file["nodes"].push_back(json::object());
             }
         },
         "", "is nested more than 1000 nodes deep"},
        {"mesh-index", set("/nodes/0/mesh", 1), "", "nodes[0].mesh = \"1\" is not an index of meshes"},
        {"mesh-text", set("/nodes/0/mesh", "0"), "", "nodes[0].mesh"},
        {"matrix-size", set("/nodes/0/matrix", {1, 0, 0}), "", "nodes[0].matrix must be an array of 16 numbers"},
        {"scale-type", set("/nodes/0/scale", {"1", 1, 1}), "", "nodes[0].scale must be an array of 3 numbers"},
        {"no-position", erase("/meshes/0/primitives/0/attributes", "POSITION"), "", "attributes has no POSITION"},
        {"mode", set("/meshes/0/primitives/0/mode", 7), "", "mode = 7 is not legal"},
        {"accessor-index", set("/meshes/0/primitives/0/indices", 2), "",
         "is not an index of accessors; the file has 2"},
        {"index-type", set("/accessors/1/componentType", 5126), "", "accessors[1].componentType = 5126 is not legal"},
        {"index-int16", set("/accessors/1/componentType", 5122), "", "legal are 5121, 5123, 5125"},
        {"position-type", set("/accessors/0/type", "VEC2"), "", "must be VEC3"},
        {"no-count", erase("/accessors/0", "count"), "", "accessors[0] has no count"},
        {"zero-count", set("/accessors/0/count", 0), "", "accessors[0].count = 0 is not legal"},
        {"negative-count", set("/accessors/0/count", -5), "", "accessors[0].count = \"-5\" is not legal"},
        {"half-count", set("/accessors/0/count", 4.5), "", "accessors[0].count = \"4.5\" is not legal"},
        {"large-count", set("/accessors/0/count", 6), "", "accessors[0] has 6 elements of 12 bytes"},
        {"huge-count", set("/accessors/0/count", 4000000000000000), "", "exceed the view's 60 bytes"},
        {"late-offset", set("/accessors/0/byteOffset", 4), "", "exceed the view's 60 bytes"},
        {"huge-offset", set("/accessors/0/byteOffset", 9007199254740992), "", "exceed the view's 60 bytes"},
        {"narrow-stride", set("/bufferViews/0/byteStride", 8), "", "the byteStride of its view is 8"},
        {"wide-stride", set("/bufferViews/0/byteStride", 16), "", "exceed the view's 60 bytes"},
        {"view-index", set("/accessors/0/bufferView", 2), "", "accessors[0].bufferView = \"2\" is not an index"},
        {"view-length", set("/bufferViews/1/byteLength", 13), "", "bufferViews[1] contains the bytes from 60 to 73"},
        {"view-offset", set("/bufferViews/1/byteOffset", 9007199254740992), "", "but its buffer has only 72"},
        {"view-buffer", set("/bufferViews/1/buffer", 1), "",
         "bufferViews[1].buffer = \"1\" is not an index of buffers"},
        {"no-view", erase("/accessors/0", "bufferView"), "", "accessors[0] has no bufferView and is not sparse"},
        {"index", [](Parts& p) { p.bytes[70] = 5; }, "", "face 1 of part \"meshes[0]\" has the vertex index 5"},
        {"nan", [](Parts& p) { p.bytes.replace(24, 4, Bytes().add<float>({NAN}).text); }, "",
         "vertex 2 of part \"meshes[0]\" is not finite: x = nan"},
        {"far", set("/nodes/0/scale", {1e20, 1e20, 1e20}), "", "too far away"},
        {"infinite", set("/nodes/0/scale", {1e308, 1e308, 1e308}), "",
         "vertex 4 of part \"meshes[0]\" is not finite: z = inf"},
        {"overflow", set("/nodes/0/matrix", {1e308, 0, 0, 0, 1e308, 1, 0, 0, 0, 0, 1, 0, 1e308, 0, 0, 1}), "",
         "is not finite: x = inf"},
        {"sparse-count", set("/accessors/0/sparse", {{"count", 6}}), "", "accessors[0].sparse.count = 6 is not legal"},
        {"sparse-parts", set("/accessors/0/sparse", {{"count", 1}}), "", "accessors[0].sparse has no indices"},
        {"sparse-index",
         [](Parts& p) {
             p.accessor(0)["sparse"] = {{"count", 1},
                                        {"indices", {{"bufferView", p.add_view("\5")}, {"componentType", 5121}}},
                                        {"values", {{"bufferView", 0}}}};
         },
         "", "indices contains 5"},
        {"sparse-values",
         [](Parts& p) {
             p.accessor(0)["sparse"] = {{"count", 2},
                                        {"indices", {{"bufferView", p.add_view("\1\2")}, {"componentType", 5121}}},
                                        {"values", {{"bufferView", 0}, {"byteOffset", 37}}}};
         },
         "", "accessors[0].sparse.values has 2 elements"},
        {"huge-sparse",
         [](Parts& p) {
             p.accessor(0).erase("bufferView");
             p.accessor(0)["count"] = 4000000000;
             p.accessor(0)["sparse"] = {{"count", 1}};
         },
         "", "is too large without a bufferView"},
        {"normal-count",
         [](Parts& p) {
             p.primitive()["attributes"]["NORMAL"] =
                 p.add_accessor(Bytes().add<float>({0, 0, 1}).text, 5126, 1, "VEC3");
         },
         "", "have different counts"},
        {"nodes-type", set("/nodes", {1}), "", "glTF: "},
        {"accessors-type", set("/accessors", 5), "", "the file.accessors must be an array"},
    };
    expect_all(changes);
}

}  // namespace kagero::test
