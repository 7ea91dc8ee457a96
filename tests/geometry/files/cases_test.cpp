// Tests of mesh files in the folder cases. They resemble files that other readers have read wrong without a message.
#include "tests/support/mesh_file_fixture.h"

#include <iterator>

namespace kagero::test {

namespace {

class CaseFile : public MeshFileTest {
protected:
    TriangleMesh read(const std::string& name) {
        std::ifstream file(std::filesystem::path(KAGERO_SOURCE) / "tests/geometry/files/cases" / name,
                           std::ios::binary);
        return mesh(name, {std::istreambuf_iterator<char>(file), {}});
    }
};

}  // namespace

// The fourth vertex is not used. If the first one were lost, the triangle would contain the fourth.
TEST_F(CaseFile, ObjFilesKeepTheirFirstVertex) {
    for (const char* name : {"obj-bom.obj", "obj-comment-backslash.obj", "obj-face-comment.obj"}) {
        EXPECT_EQ(triangles_of(read(name)), "0 0 1, 1 0 1, 1 1 1") << name;
        EXPECT_TRUE(remarks_.empty()) << name;
    }
}

TEST_F(CaseFile, StripsHaveAllTheirTriangles) {
    const TriangleMesh strip = read("ply-tristrips.ply");
    EXPECT_EQ(strip.triangles.size(), 3 * 8u);
    double area = 0;
    for (const double part : areas_of(strip)) area += part;
    EXPECT_EQ(area, 4);
    for (std::size_t i = 0; i < strip.triangles.size(); i += 3) {
        const Double3 a = vertex(strip, strip.triangles[i]);
        const Double3 normal = cross(subtract(vertex(strip, strip.triangles[i + 1]), a),
                                     subtract(vertex(strip, strip.triangles[i + 2]), a));
        EXPECT_LT(normal[2], 0) << "triangle " << i / 3 << " faces the other side";
    }
}

TEST_F(CaseFile, UnknownElementsAreSkipped) {
    EXPECT_EQ(triangles_of(read("ply-foreign-lists.ply")), "0 0 1, 1 0 1, 1 1 1");
    ASSERT_EQ(remarks_.size(), 1u);
    EXPECT_NE(remarks_[0].find("2 elements \"junk\" were left out"), std::string::npos) << remarks_[0];
}

// A ball of radius 1, with steps of 1.2e-4 between its coordinates.
TEST_F(CaseFile, QuantizedPositionsAreRead) {
    const TriangleMesh ball = read("gltf-quantized.gltf");
    EXPECT_EQ(ball.vertices.size(), 3 * 290u);
    EXPECT_EQ(ball.triangles.size(), 1728u);
    for (std::uint32_t i = 0; i < 290; ++i) EXPECT_NEAR(length(vertex(ball, i)), 1, 2e-4) << i;
    EXPECT_TRUE(remarks_.empty());
}

}  // namespace kagero::test
