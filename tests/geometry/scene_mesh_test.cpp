// Tests of meshes: broken files must be refused, and meshes are checked, transformed and remarked on.
#include "geometry/mesh.h"
#include "tests/support/scene_fixture.h"

#include <cmath>
#include <sstream>

namespace kagero::test {

namespace {

std::string ply(int vertices, int faces, const std::string& body) {
    return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(vertices) +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " + std::to_string(faces) +
           "\nproperty list uchar int vertex_indices\nend_header\n" + body;
}

/// Returns the PLY file with its first word in capital letters, which some programs write.
std::string with_capital_letters(std::string ply) { return "PLY " + ply.substr(3); }

/// Returns the PLY file with a header that declares a number after the vertex list of each face.
std::string with_second_property(std::string ply) {
    return ply.insert(ply.find("end_header"), "property int second\n");
}

std::string gltf(const std::string& nodes) {
    return R"({"asset": {"version": "2.0"}, "nodes": [)" + nodes + "]}";
}

/// Returns a glTF file with a chain of nodes, in which each node is the parent of the next.
std::string chain(int length) {
    std::string nodes;
    for (int i = 1; i < length; ++i) nodes += R"({"children": [)" + std::to_string(i) + "]}, ";
    return gltf(nodes + "{}");
}

/// Returns an OBJ file with one face.
std::string polygon(int corners) {
    std::string vertices, face = "f";
    for (int i = 0; i < corners; ++i) {
        vertices += "v " + std::to_string(i) + " " + std::to_string(i % 2) + " 0\n";
        face += " " + std::to_string(i + 1);
    }
    return vertices + face + "\n";
}

/// Vertices of a PLY file. Its header has 9 lines, so that the vertices begin in line 10.
const std::string square = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

class LoadMesh : public SceneTest {
protected:
    TriangleMesh mesh(const std::string& name, const std::string& text) {
        object_.name = "thing";
        object_.shape = Shape::mesh;
        object_.file = write(name, text);
        object_.file_location = {"scene.toml", 7, 8};
        return load_mesh(object_, space_center_, remarks_);
    }
    std::string mesh_refusal(const std::string& name, const std::string& text) {
        try {
            mesh(name, text);
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    }

    ObjectDescription object_;
    Double3 space_center_{0, 0, 0};
    std::vector<std::string> remarks_;
};

struct BadMesh {
    const char* name;
    std::string text;
    const char* fragment;
};

}  // namespace

TEST_F(LoadMesh, RefusesBrokenFiles) {
    const BadMesh cases[] = {
        {"nan.ply", ply(4, 1, "0 0 0\n1 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n"), "scene.toml:7:8: object.thing.file"},
        {"nan.ply", ply(4, 1, "0 0 0\n1 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n"), "vertex 2 of part \"\" is not finite"},
        {"index.ply", ply(4, 2, square + "3 0 1 2\n3 0 2 9\n"),
         "face 1 has the vertex index 9, but its part has only 4 vertices"},
        {"negative.ply", ply(4, 1, square + "3 0 1 -1\n"), "face 0 has the vertex index -1"},
        {"short.ply", ply(4, 2, square + "3 0 1 2\n"), "short.ply:14: PLY: the header declares 2 elements \"face\""},
        {"large.ply", with_capital_letters(ply(4, 2, square + "3 0 1 2\n")),
         "large.ply:14: PLY: the header declares 2 elements \"face\""},
        {"count.ply", with_second_property(ply(4, 1, square + "-1\n")),
         "count.ply:15: PLY: a list of an element \"face\" declares more entries"},
        {"long.ply", ply(4, 1, square + "3 0 1 2\n3 0 2 3\n"), "long.ply:15: PLY: the file contains more data"},
        {"vertices.ply", ply(9, 1, square + "3 0 1 2\n"),
         "vertices.ply:14: PLY: expected 3 numbers for an element \"vertex\", got 4"},
        {"cut.ply", ply(4, 1, "0 0 0\n1 0 0\n1 1 0\n0 1"),
         "cut.ply:13: PLY: expected 3 numbers for an element \"vertex\", got 2"},
        {"head.ply", "ply\nformat ascii 1.0\n", "the file ends inside the header"},
        {"empty.ply", "", "empty.ply\": the file cannot be read"},
        {"flat.ply", ply(4, 1, square + "3 0 0 1\n"), "has no triangle with a nonzero area"},
        {"nan.obj", "v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n", "vertex 2 of part \"defaultobject\" is not finite"},
        {"inf.obj", "v 0 0 0\nv 1 0 0\nv 1e400 1 0\nf 1 2 3\n", "is not finite"},
        {"index.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 9\n", "index out of range"},
        {"points.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\n", "has no triangle with a nonzero area"},
        {"polygon.obj", polygon(30001), "face 0 has 30001 vertices; the limit is 30000"},
        {"middle.ply", "ply\nformat middle_endian 1.0\nend_header\n",
         "middle.ply:2: PLY: format middle_endian is not known"},
        {"junk.glb", "hello", "junk.glb: glTF: parse error at line 1, column 1"},
        {"none.gltf", R"({"asset": {"version": "1.0"}})", "the file cannot be read: it contains no scene"},
        {"list.gltf", "[]", "list.gltf: glTF: "},
        {"two.gltf", gltf(R"({"children": [2]}, {"children": [2]}, {})"), "node 2 is a child of two nodes"},
        {"cycle.gltf", gltf(R"({"children": [1]}, {"children": [0]})"), "belongs to a cycle"},
        {"named.gltf",
         R"({"asset": {"version": "1.0"}, "nodes": {"a": {"children": ["b"]}, "b": {"children": ["a"]}}})",
         "node a is nested"},
        {"chain.gltf", chain(30000), "is nested more than 1000 nodes deep"},
        {"deep.gltf", std::string(1000000, '['), "brackets are nested deeper than the limit of 1000"},
    };
    for (const BadMesh& entry : cases) {
        const std::string message = mesh_refusal(entry.name, entry.text);
        EXPECT_NE(message.find(entry.fragment), std::string::npos) << entry.name << "\n" << message;
    }
}

TEST_F(LoadMesh, RefusesTruncatedBinaryPly) {
    std::string text = ply(3, 1, "");
    text.replace(text.find("ascii"), 5, "binary_little_endian");
    const float points[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const std::int32_t indices[3] = {0, 1, 2};
    text.append(reinterpret_cast<const char*>(points), sizeof points);
    text += '\3';
    text.append(reinterpret_cast<const char*>(indices), sizeof indices);
    EXPECT_EQ(mesh("whole.ply", text).triangles.size(), 3u);
    for (const std::size_t cut : {1u, 5u, 12u, 13u, 20u}) {
        const std::string message = mesh_refusal("cut.ply", text.substr(0, text.size() - cut));
        EXPECT_NE(message.find("but the file ends after"), std::string::npos) << cut << "\n" << message;
    }
    EXPECT_NE(mesh_refusal("more.ply", text + "more").find("the file contains more data"), std::string::npos);
}

TEST_F(LoadMesh, DropsDegenerateTrianglesWithARemark) {
    EXPECT_EQ(mesh("some.ply", ply(4, 3, square + "3 0 1 2\n3 0 0 2\n3 0 2 3\n")).triangles.size(), 6u);
    ASSERT_EQ(remarks_.size(), 1u);
    EXPECT_EQ(remarks_[0], "object thing: 1 triangles without area were left out");
}

TEST_F(LoadMesh, RemarksOnCoordinatesThatSinglePrecisionRounds) {
    mesh("near.obj", "v 500 4000 0\nv 501 4000 0\nv 501 4001 0\nf 1 2 3\n");
    EXPECT_TRUE(remarks_.empty());
    mesh("far.obj", "v 500000.1 4000000.1 0\nv 500001.1 4000000.1 0\nv 500001.1 4000001.1 0\nf 1 2 3\n");
    ASSERT_EQ(remarks_.size(), 1u);
    EXPECT_NE(remarks_[0].find("single precision"), std::string::npos) << remarks_[0];
}

TEST_F(LoadMesh, RemarksOnPartsWithoutTextureCoordinates) {
    const std::string parts =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\ng a\nf 1/1 2/2 3/3\ng b\nf 1 3 4\n";
    mesh("plain.obj", parts);
    EXPECT_TRUE(remarks_.empty());
    object_.paint.kind = Paint::Kind::checker;
    mesh("parts.obj", parts);
    ASSERT_EQ(remarks_.size(), 1u);
    EXPECT_NE(remarks_[0].find("3 vertices without texture coordinates"), std::string::npos) << remarks_[0];
}

TEST_F(LoadMesh, TriangulatesAndTransforms) {
    object_.scale = 2;
    object_.rotate = {90, 0, 90};  // x → y, y → z, z → x
    object_.translate = {10, 20, 30};
    space_center_ = {1, 1, 1};
    const TriangleMesh placed = mesh("square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    ASSERT_EQ(placed.triangles.size(), 6u);
    EXPECT_EQ(vertex(placed, 0), (Double3{9, 19, 29}));
    EXPECT_EQ(vertex(placed, 1), (Double3{9, 21, 29}));
    EXPECT_EQ(vertex(placed, 3), (Double3{9, 19, 31}));
}

// Normals are transformed by the inverse transpose of the scale of a node, for any size of the scale.
TEST_F(LoadMesh, TransformsNormalsOfNodesOfAnySize) {
    const float third = 1 / 3.0f;
    const float numbers[18] = {0,     0,         0,         1,     0,         0,         0,     1,         0,
                               third, 2 * third, 2 * third, third, 2 * third, 2 * third, third, 2 * third, 2 * third};
    write("three.bin", std::string(reinterpret_cast<const char*>(numbers), sizeof numbers));
    for (const double size : {1.0, 1e-13, 1e-15, 1e13})
        for (const int sign : {1, -1}) {
            std::ostringstream scale;
            scale << '[' << size << ", " << 2 * size << ", " << sign * size << ']';
            const TriangleMesh scaled =
                mesh("three.gltf", R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
                "nodes": [{"mesh": 0, "scale": )" +
                                       scale.str() + R"(}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}}]}],
                "buffers": [{"uri": "three.bin", "byteLength": 72}],
                "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 36},
                                {"buffer": 0, "byteOffset": 36, "byteLength": 36}],
                "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                               "min": [0, 0, 0], "max": [1, 1, 0]},
                              {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"}]})");
            ASSERT_EQ(scaled.normals.size(), 9u);
            const double expected[3] = {1, 1, 2.0 * sign};  // proportional to (1, 2, 2)/3 divided by the scale
            for (std::size_t k = 0; k < 9; ++k)
                EXPECT_NEAR(scaled.normals[k], expected[k % 3] / std::sqrt(6.0), 1e-6) << scale.str() << k;
        }
}

}  // namespace kagero::test
